-- As SQLite's migration of this number.
ALTER TABLE jobs ADD COLUMN trace TEXT;
