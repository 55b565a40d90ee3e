"""Where nothing that is known fits: a force drafted as a short formula, written as an effect of one's own, and tried."""
