"""The verb `simulate`: work orders in virtual time."""
