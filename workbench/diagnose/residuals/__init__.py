"""The balances of a record: what it leaves of each, with its floor, and fits of the parameters to that."""
