-- What a match is called by who asked for it.
ALTER TABLE jobs ADD COLUMN name TEXT;
