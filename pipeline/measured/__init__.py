"""Effects put into measured runs by rewriting what their logs claim was commanded."""
