"""The page of an explanation: the story, the figures, the tables, and what it is made from."""
