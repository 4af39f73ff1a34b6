"""Parts of `work_precision`: cases, fronts and what is read off them, one scene, sentences, pictures."""
