"""Planning that would hold up a door or the tick thread, in processes of its own."""
