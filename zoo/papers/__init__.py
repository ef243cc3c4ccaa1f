"""What four papers print, and the same quantities of models trained here on runs like theirs."""
