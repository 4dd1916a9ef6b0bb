-- The survey's database. Times are seconds since 1970, by the server's clock. Nothing here tells who a participant is.
CREATE TABLE IF NOT EXISTS facts (name TEXT PRIMARY KEY, value TEXT NOT NULL) STRICT;
CREATE TABLE IF NOT EXISTS participants (
  id INTEGER PRIMARY KEY AUTOINCREMENT,  -- of those who withdrew, no number is given again
  digest TEXT NOT NULL UNIQUE,           -- of the code
  order_row TEXT NOT NULL,
  videos TEXT NOT NULL,                  -- codes by place, as JSON
  choices TEXT NOT NULL,                 -- labels in the order of the page, as JSON
  consent_version TEXT NOT NULL,
  enrolled REAL NOT NULL,
  seen REAL NOT NULL,
  about TEXT,                            -- the answers about the participant, as JSON
  instructed REAL,
  submitted REAL,
  after TEXT,                            -- the answers to the questions after the videos, as JSON
  language TEXT NOT NULL DEFAULT '',
  kit_version INTEGER NOT NULL DEFAULT 1
) STRICT;
CREATE TABLE IF NOT EXISTS views (
  participant INTEGER NOT NULL REFERENCES participants ON DELETE CASCADE,
  place INTEGER NOT NULL,
  shown REAL NOT NULL,
  opened REAL,                           -- when it was watched and could be answered
  PRIMARY KEY (participant, place)
) STRICT;
CREATE TABLE IF NOT EXISTS plays (
  participant INTEGER NOT NULL REFERENCES participants ON DELETE CASCADE,
  place INTEGER NOT NULL,
  play TEXT NOT NULL,                    -- drawn by the page: a report that comes twice counts once
  started REAL NOT NULL,
  share REAL NOT NULL DEFAULT 0,
  device TEXT NOT NULL,
  width INTEGER NOT NULL,
  height INTEGER NOT NULL,
  frames INTEGER NOT NULL DEFAULT 0,
  dropped INTEGER NOT NULL DEFAULT 0,
  stalls INTEGER NOT NULL DEFAULT 0,     -- times that it stood still, waiting for data
  stalled_ms INTEGER NOT NULL DEFAULT 0,
  play_ms INTEGER NOT NULL DEFAULT 0,    -- from the first frame to the last one, without pauses
  PRIMARY KEY (participant, place, play)
) STRICT;
CREATE TABLE IF NOT EXISTS answers (                   -- one row for each change; the last one counts
  id INTEGER PRIMARY KEY,
  participant INTEGER NOT NULL REFERENCES participants ON DELETE CASCADE,
  place INTEGER NOT NULL,
  response TEXT NOT NULL,
  ratings TEXT NOT NULL,                 -- as JSON
  given REAL NOT NULL,
  response_ms INTEGER                    -- as the browser measured it
) STRICT;
CREATE INDEX IF NOT EXISTS answers_of ON answers (participant, place);
-- Participants sent by a recruitment service. No row here can be joined with one above: the digest is another one, and
-- without a row number there is no common sequence.
CREATE TABLE IF NOT EXISTS recruits (
  digest TEXT PRIMARY KEY,
  parameters TEXT NOT NULL,              -- of the survey's address, as JSON
  outcome TEXT NOT NULL                  -- started, finished, failed
) STRICT, WITHOUT ROWID;
CREATE TABLE IF NOT EXISTS withdrawn (digest TEXT PRIMARY KEY) STRICT;
