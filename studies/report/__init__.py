"""What a run leaves: its answer as text, tables, pictures and pages."""
