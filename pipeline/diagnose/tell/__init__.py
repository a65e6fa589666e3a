"""What is told: the verdict in a sentence, and what no vehicle file can say."""
