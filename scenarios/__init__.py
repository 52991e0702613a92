"""The scenarios that come with cohaptic; a package, so that an installed wheel carries them."""
