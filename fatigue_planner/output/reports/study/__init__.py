"""The page of a finished sensitivity study."""
