"""Raw folders of the bundled vehicles, design cases and blank forms that come with the program."""
