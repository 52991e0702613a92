"""From the forms to a checked scenario: names looked up, times in ticks, rates that fit."""
