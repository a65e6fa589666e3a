"""The vehicle file: its schema and its reader."""
