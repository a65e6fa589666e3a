"""What several commands have alike: options, progress, exit codes, faults, language of help."""
