"""Memory that the processes of one paced run share: mapped files, and a ring of texts in one."""
