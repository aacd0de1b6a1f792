"""What several formats share: tables, contact laws, decks from templates."""
