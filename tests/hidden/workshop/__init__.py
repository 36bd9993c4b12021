"""Records as from a workshop: a second generator, whose physics, motions and robots share nothing with the first one's."""
