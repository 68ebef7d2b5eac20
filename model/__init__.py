"""What a trained garment needs at inference, or what two stages share. Knows nothing of shards or stages."""
