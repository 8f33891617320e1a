#include "studies/ledger.h"

#include <SQLiteCpp/SQLiteCpp.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "core/errors.h"
#include "core/json.h"

namespace powdercal {
namespace {

using nlohmann::json;

constexpr int kSchema = 2;                  // 1: without candidates.fidelity
constexpr int kApplicationId = 0x70646361;  // marks the file as a powdercal ledger

constexpr const char* kCreate = R"(
CREATE TABLE meta (key TEXT PRIMARY KEY, value TEXT NOT NULL) WITHOUT ROWID;
CREATE TABLE runs (
  id INTEGER PRIMARY KEY, key TEXT NOT NULL UNIQUE, experiment TEXT NOT NULL,
  program_hash TEXT NOT NULL, seed TEXT NOT NULL, backend TEXT NOT NULL,
  backend_version TEXT NOT NULL, fidelity TEXT NOT NULL, reason TEXT NOT NULL,
  message TEXT NOT NULL, responses TEXT NOT NULL, diagnostics TEXT NOT NULL,
  simulator_seconds REAL NOT NULL, total_seconds REAL NOT NULL,
  ended TEXT NOT NULL DEFAULT (strftime('%Y-%m-%dT%H:%M:%SZ')));
CREATE TABLE candidates (
  id INTEGER PRIMARY KEY, point TEXT NOT NULL, parameters TEXT NOT NULL, origin TEXT NOT NULL,
  cached_runs INTEGER NOT NULL DEFAULT 0, fidelity REAL NOT NULL DEFAULT 1);
CREATE TABLE candidate_runs (
  candidate INTEGER NOT NULL REFERENCES candidates(id), run INTEGER NOT NULL REFERENCES runs(id),
  replicate INTEGER NOT NULL, UNIQUE (candidate, run));
CREATE TABLE events (
  id INTEGER PRIMARY KEY, kind TEXT NOT NULL CHECK (kind IN ('ask', 'tell')),
  payload TEXT NOT NULL);
CREATE TABLE sessions (
  id INTEGER PRIMARY KEY, started TEXT NOT NULL DEFAULT (strftime('%Y-%m-%dT%H:%M:%SZ')),
  wall_seconds REAL NOT NULL DEFAULT 0, overhead_seconds REAL NOT NULL DEFAULT 0);
)";

json ToJson(const Eigen::VectorXd& vector) {
  json list = json::array();
  for (const double value : vector) list.push_back(JsonNumber(value));
  return list;
}

Eigen::VectorXd VectorFromJson(const json& list) {
  Eigen::VectorXd vector(static_cast<Eigen::Index>(list.size()));
  for (std::size_t i = 0; i < list.size(); ++i) {
    vector[static_cast<Eigen::Index>(i)] =
        list[i].is_null() ? std::numeric_limits<double>::quiet_NaN() : list[i].get<double>();
  }
  return vector;
}

json ToJson(const Measurement& measurement) {
  json responses = json::object();
  for (const auto& [name, response] : measurement.responses) {
    responses[name] = {{"value", response.value}, {"variance", response.variance}};
  }
  return {{"responses", responses}, {"diagnostics", measurement.diagnostics}};
}

Measurement MeasurementFromJson(const json& value) {
  Measurement measurement;
  for (const auto& [name, response] : value.at("responses").items()) {
    measurement.responses[name] = {response.at("value"), response.at("variance")};
  }
  for (const auto& [name, number] : value.at("diagnostics").items()) {
    // A diagnostic that was not finite is stored as null and left out.
    if (number.is_number()) measurement.diagnostics[name] = number.get<double>();
  }
  return measurement;
}

double NumberOr(const json& value, const char* key, double fallback) {
  const auto found = value.find(key);
  return found != value.end() && found->is_number() ? found->get<double>() : fallback;
}

Diagnostics DiagnosticsFromJson(const json& value) {
  Diagnostics d;
  d.steps = value.at("steps");
  d.time_step = NumberOr(value, "time_step", 0);
  d.lost_particles = value.at("lost_particles");
  d.leavers = value.value("leavers", 0);
  d.kinetic_energy = NumberOr(value, "kinetic_energy", 0);
  d.kinetic_energy_ratio = NumberOr(value, "kinetic_energy_ratio", 0);
  d.max_overlap = NumberOr(value, "max_overlap", 0);
  d.law = value.at("law");
  return d;
}

json ToJson(const Observation& o) {
  return {{"id", o.id},
          {"point", ToJson(o.point)},
          {"responses", ToJson(o.responses)},
          {"variances", ToJson(o.variances)},
          {"failed", o.failed},
          {"failure", o.failure},
          {"fidelity", o.fidelity}};
}

Observation ObservationFromJson(const json& value) {
  return {.id = value.at("id"),
          .point = VectorFromJson(value.at("point")),
          .responses = VectorFromJson(value.at("responses")),
          .variances = VectorFromJson(value.at("variances")),
          .failed = value.at("failed"),
          .failure = value.at("failure"),
          .fidelity = NumberOr(value, "fidelity", 1)};
}

Reason ReasonFromName(const std::string& name) {
  const auto names = ReasonNames();
  const auto found = std::find(names.begin(), names.end(), name);
  return found == names.end() ? Reason::crashed : static_cast<Reason>(found - names.begin());
}

constexpr const char* kRunColumns =
    "id, key, experiment, program_hash, seed, backend, backend_version, fidelity, reason, message, "
    "responses, diagnostics, simulator_seconds, total_seconds";

LedgerRun ReadRun(SQLite::Statement& row) {
  LedgerRun run;
  run.id = row.getColumn(0).getInt64();
  run.key = row.getColumn(1).getString();
  run.experiment = row.getColumn(2).getString();
  run.program_hash = row.getColumn(3).getString();
  run.seed = std::stoull(row.getColumn(4).getString());
  run.backend = row.getColumn(5).getString();
  run.backend_version = row.getColumn(6).getString();
  run.fidelity = row.getColumn(7).getString();
  run.outcome = {ReasonFromName(row.getColumn(8).getString()), row.getColumn(9).getString()};
  run.measurement = MeasurementFromJson(json::parse(row.getColumn(10).getString()));
  run.diagnostics = DiagnosticsFromJson(json::parse(row.getColumn(11).getString()));
  run.diagnostics.wall_seconds = row.getColumn(12).getDouble();
  run.total_seconds = row.getColumn(13).getDouble();
  return run;
}

void Attach(SQLite::Database& database, std::int64_t run, std::int64_t candidate, int replicate) {
  SQLite::Statement insert(database, "INSERT OR IGNORE INTO candidate_runs VALUES (?, ?, ?)");
  insert.bind(1, candidate);
  insert.bind(2, run);
  insert.bind(3, replicate);
  insert.exec();
}

void AddEvent(SQLite::Database& database, const char* kind, const json& payload) {
  SQLite::Statement insert(database, "INSERT INTO events (kind, payload) VALUES (?, ?)");
  insert.bind(1, kind);
  insert.bind(2, payload.dump());
  insert.exec();
}

}  // namespace

Ledger::Ledger(const std::filesystem::path& file, Mode mode) {
  const int flags = mode == Mode::read_only ? SQLite::OPEN_READONLY
                                            : SQLite::OPEN_READWRITE | SQLite::OPEN_CREATE;
  try {
    database_ = std::make_unique<SQLite::Database>(file.string(), flags, 10'000);
    const bool empty = database_->execAndGet("SELECT count(*) FROM sqlite_master").getInt() == 0;
    if (empty && mode == Mode::read_write) {
      database_->exec("PRAGMA journal_mode = WAL");
      SQLite::Transaction transaction(*database_);
      database_->exec(kCreate);
      database_->exec(fmt::format("PRAGMA application_id = {}", kApplicationId));
      database_->exec(fmt::format("PRAGMA user_version = {}", kSchema));
      transaction.commit();
    }
    if (database_->execAndGet("PRAGMA application_id").getInt() != kApplicationId) {
      throw InputError("not a powdercal ledger", {.location = {file.string()}});
    }
    schema_ = database_->execAndGet("PRAGMA user_version").getInt();
    if (schema_ < 1 || schema_ > kSchema) {
      throw InputError(
          fmt::format("the ledger has schema {}, this program knows 1 to {}", schema_, kSchema),
          {.location = {file.string()}});
    }
    // A damaged ledger is found here rather than in the middle of a study; it takes milliseconds.
    const std::string damage = database_->execAndGet("PRAGMA quick_check(1)").getString();
    if (damage != "ok") {
      throw InputError("the ledger is damaged: " + damage.substr(damage.rfind('\n') + 1),
                       {.location = {file.string()}});
    }
    // FULL: a commit survives a power cut, not only the death of the process.
    database_->exec("PRAGMA synchronous = FULL");
    database_->exec("PRAGMA foreign_keys = ON");
    if (schema_ == 1 && mode == Mode::read_write) Upgrade();
  } catch (const SQLite::Exception& error) {
    throw InputError(fmt::format("cannot open the ledger: {}", error.what()),
                     {.location = {file.string()}});
  }
}

Ledger::~Ledger() = default;

void Ledger::Upgrade() {
  SQLite::Transaction transaction(*database_);
  database_->exec("ALTER TABLE candidates ADD COLUMN fidelity REAL NOT NULL DEFAULT 1");
  database_->exec(fmt::format("PRAGMA user_version = {}", kSchema));
  transaction.commit();
  schema_ = kSchema;
}

bool Ledger::IsBlank(const std::filesystem::path& file) {
  try {
    // For writing: what a killed process left half done has to be rolled back before it can be
    // read.
    SQLite::Database database(file.string(), SQLite::OPEN_READWRITE, 10'000);
    return database.execAndGet("SELECT count(*) FROM sqlite_master").getInt() == 0;
  } catch (const SQLite::Exception&) {
    return false;
  }
}

std::optional<std::string> Ledger::GetMeta(const std::string& key) const {
  SQLite::Statement query(*database_, "SELECT value FROM meta WHERE key = ?");
  query.bind(1, key);
  if (!query.executeStep()) return std::nullopt;
  return query.getColumn(0).getString();
}

void Ledger::SetMeta(const std::string& key, const std::string& value) {
  SQLite::Statement insert(*database_, "INSERT OR REPLACE INTO meta VALUES (?, ?)");
  insert.bind(1, key);
  insert.bind(2, value);
  insert.exec();
}

std::optional<LedgerRun> Ledger::FindRun(const std::string& key) const {
  SQLite::Statement query(*database_,
                          fmt::format("SELECT {} FROM runs WHERE key = ?", kRunColumns));
  query.bind(1, key);
  if (!query.executeStep()) return std::nullopt;
  return ReadRun(query);
}

LedgerRun Ledger::GetRun(std::int64_t id) const {
  SQLite::Statement query(*database_, fmt::format("SELECT {} FROM runs WHERE id = ?", kRunColumns));
  query.bind(1, id);
  if (!query.executeStep()) throw std::out_of_range(fmt::format("the ledger has no run {}", id));
  return ReadRun(query);
}

std::vector<LedgerRun> Ledger::Runs() const {
  SQLite::Statement query(*database_, fmt::format("SELECT {} FROM runs ORDER BY id", kRunColumns));
  std::vector<LedgerRun> runs;
  while (query.executeStep()) runs.push_back(ReadRun(query));
  return runs;
}

std::int64_t Ledger::AddRun(const LedgerRun& run, std::int64_t candidate, int replicate) {
  SQLite::Transaction transaction(*database_);
  SQLite::Statement insert(
      *database_,
      "INSERT INTO runs (key, experiment, program_hash, seed, backend, backend_version, fidelity, "
      "reason, message, responses, diagnostics, simulator_seconds, total_seconds) "
      "VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?)");
  insert.bind(1, run.key);
  insert.bind(2, run.experiment);
  insert.bind(3, run.program_hash);
  insert.bind(4, std::to_string(run.seed));  // unsigned 64 bits do not fit SQLite's integers
  insert.bind(5, run.backend);
  insert.bind(6, run.backend_version);
  insert.bind(7, run.fidelity);
  insert.bind(8, ToString(run.outcome.reason));
  insert.bind(9, run.outcome.message);
  insert.bind(10, ToJson(run.measurement).dump());
  insert.bind(11, ToJson(run.diagnostics).dump());
  insert.bind(12, run.diagnostics.wall_seconds);
  insert.bind(13, run.total_seconds);
  insert.exec();
  const std::int64_t id = database_->getLastInsertRowid();
  Attach(*database_, id, candidate, replicate);
  transaction.commit();
  return id;
}

void Ledger::AttachRun(std::int64_t run, std::int64_t candidate, int replicate) {
  Attach(*database_, run, candidate, replicate);
}

void Ledger::AddAsk(int max_count, const std::vector<LedgerCandidate>& candidates) {
  SQLite::Transaction transaction(*database_);
  json ids = json::array();
  for (const LedgerCandidate& entry : candidates) {
    SQLite::Statement insert(*database_,
                             "INSERT INTO candidates (id, point, parameters, origin, fidelity) "
                             "VALUES (?, ?, ?, ?, ?)");
    insert.bind(1, entry.candidate.id);
    insert.bind(2, ToJson(entry.candidate.point).dump());
    insert.bind(3, json(entry.parameters).dump());
    insert.bind(4, entry.candidate.origin);
    insert.bind(5, entry.candidate.fidelity);
    insert.exec();
    ids.push_back(entry.candidate.id);
  }
  AddEvent(*database_, "ask", {{"max_count", max_count}, {"candidates", ids}});
  transaction.commit();
}

void Ledger::SetCachedRuns(std::int64_t candidate, int count) {
  SQLite::Statement update(*database_, "UPDATE candidates SET cached_runs = ? WHERE id = ?");
  update.bind(1, count);
  update.bind(2, candidate);
  update.exec();
}

void Ledger::AddTell(const Observation& observation, int replicates) {
  AddEvent(*database_, "tell", {{"observation", ToJson(observation)}, {"replicates", replicates}});
}

std::vector<LedgerCandidate> Ledger::Candidates() const {
  std::vector<LedgerCandidate> list;
  SQLite::Statement query(
      *database_,
      fmt::format(
          "SELECT id, point, parameters, origin, cached_runs, {} FROM candidates ORDER BY id",
          schema_ == 1 ? "1" : "fidelity"));
  while (query.executeStep()) {
    LedgerCandidate entry;
    entry.candidate.id = query.getColumn(0).getInt64();
    entry.candidate.point = VectorFromJson(json::parse(query.getColumn(1).getString()));
    entry.parameters = json::parse(query.getColumn(2).getString()).get<std::vector<double>>();
    entry.candidate.origin = query.getColumn(3).getString();
    entry.cached_runs = query.getColumn(4).getInt();
    entry.candidate.fidelity = query.getColumn(5).getDouble();
    list.push_back(std::move(entry));
  }
  SQLite::Statement links(
      *database_,
      "SELECT candidate, run, replicate FROM candidate_runs ORDER BY candidate, "
      "replicate, run");
  while (links.executeStep()) {
    const std::int64_t id = links.getColumn(0).getInt64();
    const auto entry = std::find_if(list.begin(), list.end(),
                                    [&](const LedgerCandidate& c) { return c.candidate.id == id; });
    if (entry == list.end()) {
      throw InputError(fmt::format("the ledger is damaged: it has runs of candidate {}, which it "
                                   "does not know",
                                   id),
                       {.location = {database_->getFilename()}});
    }
    entry->runs.push_back(links.getColumn(1).getInt64());
    entry->replicates.push_back(links.getColumn(2).getInt());
  }
  return list;
}

std::vector<LedgerEvent> Ledger::Events() const {
  std::vector<LedgerEvent> events;
  SQLite::Statement query(*database_, "SELECT kind, payload FROM events ORDER BY id");
  while (query.executeStep()) {
    const json payload = json::parse(query.getColumn(1).getString());
    LedgerEvent event;
    if (query.getColumn(0).getString() == "ask") {
      event.kind = LedgerEvent::Kind::ask;
      event.max_count = payload.at("max_count");
      event.candidates = payload.at("candidates").get<std::vector<std::int64_t>>();
    } else {
      event.kind = LedgerEvent::Kind::tell;
      event.observation = ObservationFromJson(payload.at("observation"));
      event.replicates = payload.at("replicates");
    }
    events.push_back(std::move(event));
  }
  return events;
}

std::int64_t Ledger::StartSession() {
  database_->exec("INSERT INTO sessions DEFAULT VALUES");
  return database_->getLastInsertRowid();
}

void Ledger::UpdateSession(std::int64_t session, const Times& times) {
  SQLite::Statement update(
      *database_, "UPDATE sessions SET wall_seconds = ?, overhead_seconds = ? WHERE id = ?");
  update.bind(1, times.wall);
  update.bind(2, times.overhead);
  update.bind(3, session);
  update.exec();
}

Ledger::Times Ledger::TotalTimes() const {
  SQLite::Statement query(*database_,
                          "SELECT total(wall_seconds), total(overhead_seconds) FROM sessions");
  query.executeStep();
  return {query.getColumn(0).getDouble(), query.getColumn(1).getDouble()};
}

}  // namespace powdercal
