"""A film, or a folder of pictures, as a stream of grey pictures."""
