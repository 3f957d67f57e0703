"""The plant simulated along the records: effects compete for what it leaves of them."""
