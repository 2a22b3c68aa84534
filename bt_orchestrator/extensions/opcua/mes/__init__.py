"""Our model in the words of ISA-95 Job Control and PackML, and back; pure."""
