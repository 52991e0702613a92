"""The evidence as a page: HTML beside the runs, Markdown in the docs, figures for both."""
