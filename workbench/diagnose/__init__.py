"""From a measured record and the plant that is believed to what that plant lacks."""
