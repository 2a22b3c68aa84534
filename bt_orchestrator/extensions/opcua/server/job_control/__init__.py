"""ISA-95 Job Control (OPC 10031-4): orders in, jobs and their responses out."""
