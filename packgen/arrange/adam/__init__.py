"""The paper's algorithm: batches that Adam moves to where its objective is least."""
