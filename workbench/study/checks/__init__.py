"""What a study asks for, checked before it runs."""
