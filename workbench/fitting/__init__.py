"""What all fits to records share: the plant simulated along a record, and the uncertainty of a fit."""
