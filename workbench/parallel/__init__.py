"""Work done several at a time, on this machine's cores or on a cluster."""
