"""The tabs: of each method its state, what can be done to it, and what is seen of it."""
