"""The computed plate: laminated Mindlin shells with piezo patches, and their reduced models."""
