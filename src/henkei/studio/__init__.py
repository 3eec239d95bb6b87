"""The browser studio: all methods live in a page, served by this process."""
