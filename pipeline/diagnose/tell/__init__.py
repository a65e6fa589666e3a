"""What is written down: the record, its sentence and notes, the next run, the corrected file."""
