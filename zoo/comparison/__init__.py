"""Models judged side by side: who predicts, what is one method, how far it is from the noise and from the others."""
