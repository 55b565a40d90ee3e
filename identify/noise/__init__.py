"""The noise of a channel: what it is, how it is made independent from sample to sample, how it is estimated."""
