"""The figures of Braun and Peyrard, PRE 82, 036117, from shipped scenes, one number each beside an exact one."""
