"""The mathematics that methods share: operators, embeddings, distances, correspondence."""
