"""The runs of a campaign, what differs between them, and their noise."""
