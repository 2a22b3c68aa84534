"""Job orders and their responses in the words of ISA-95 and B2MML, and back."""
