#include "studies/ledger.h"

#include <SQLiteCpp/SQLiteCpp.h>
#include <gmock/gmock.h>

#include <cmath>

#include "tests/support/program.h"

namespace powdercal {
namespace {

LedgerRun SampleRun(const std::string& key) {
  LedgerRun run{.key = key,
                .experiment = "consolidation",
                .program_hash = "abc",
                .seed = 18446744073709551615ULL,
                .backend = "liggghts",
                .backend_version = "3.8.0",
                .fidelity = "quick"};
  run.measurement.responses["void_ratio"] = {0.1 + 0.2, 1e-300};
  run.measurement.diagnostics["kappa"] = 334.5;
  run.diagnostics.steps = 123456789012;
  run.diagnostics.time_step = 2.77e-7;
  run.diagnostics.wall_seconds = 3.25;
  run.diagnostics.law = "hertz";
  run.total_seconds = 3.5;
  return run;
}

TEST(Ledger, GivesBackARunBitForBit) {
  const TemporaryFolder folder;
  {
    Ledger ledger(folder / "ledger.sqlite", Ledger::Mode::read_write);
    ledger.AddAsk(1, {{.candidate = {.id = 0, .point = Eigen::Vector2d(0.1, 1.0 / 3)},
                       .parameters = {47500, 0.5}}});
    ledger.AddRun(SampleRun("key"), 0, 2);
  }
  const Ledger ledger(folder / "ledger.sqlite", Ledger::Mode::read_only);
  const auto run = ledger.FindRun("key");
  ASSERT_TRUE(run);
  EXPECT_EQ(run->seed, 18446744073709551615ULL);
  EXPECT_EQ(run->measurement.responses.at("void_ratio").value, 0.1 + 0.2);
  EXPECT_EQ(run->measurement.responses.at("void_ratio").variance, 1e-300);
  EXPECT_EQ(run->measurement.diagnostics.at("kappa"), 334.5);
  EXPECT_EQ(run->diagnostics.steps, 123456789012);
  EXPECT_EQ(run->diagnostics.wall_seconds, 3.25);
  EXPECT_EQ(run->total_seconds, 3.5);
  EXPECT_TRUE(run->outcome.ok());
  const auto candidates = ledger.Candidates();
  ASSERT_EQ(candidates.size(), 1u);
  EXPECT_EQ(candidates[0].candidate.point[1], 1.0 / 3);
  EXPECT_EQ(candidates[0].parameters, (std::vector<double>{47500, 0.5}));
  EXPECT_EQ(candidates[0].replicates, std::vector<int>{2});
}

TEST(Ledger, KeepsFailuresWithTheirReason) {
  const TemporaryFolder folder;
  Ledger ledger(folder / "ledger.sqlite", Ledger::Mode::read_write);
  ledger.AddAsk(1, {{.candidate = {.id = 0, .point = Eigen::VectorXd::Zero(1)}}});
  LedgerRun run = SampleRun("failed");
  run.outcome = {Reason::not_quasi_static, "still moves"};
  run.measurement = {};
  ledger.AddRun(run, 0, 0);
  const auto found = ledger.FindRun("failed");
  ASSERT_TRUE(found);
  EXPECT_EQ(found->outcome.reason, Reason::not_quasi_static);
  EXPECT_EQ(found->outcome.message, "still moves");
}

TEST(Ledger, EventsComeBackInOrder) {
  const TemporaryFolder folder;
  Ledger ledger(folder / "ledger.sqlite", Ledger::Mode::read_write);
  const Eigen::VectorXd point = Eigen::VectorXd::Constant(1, 0.25);
  ledger.AddAsk(
      4, {{.candidate = {.id = 0, .point = point}}, {.candidate = {.id = 1, .point = point}}});
  Observation told{.id = 1,
                   .point = point,
                   .responses = Eigen::VectorXd::Constant(1, std::nan("")),
                   .variances = Eigen::VectorXd::Zero(1),
                   .failed = true,
                   .failure = "timeout"};
  ledger.AddTell(told, 3);
  const auto events = ledger.Events();
  ASSERT_EQ(events.size(), 2u);
  EXPECT_EQ(events[0].kind, LedgerEvent::Kind::ask);
  EXPECT_EQ(events[0].max_count, 4);
  EXPECT_EQ(events[0].candidates, (std::vector<std::int64_t>{0, 1}));
  EXPECT_EQ(events[1].replicates, 3);
  EXPECT_TRUE(events[1].observation->failed);
  EXPECT_TRUE(std::isnan(events[1].observation->responses[0]));
  EXPECT_EQ(events[1].observation->failure, "timeout");
}

TEST(Ledger, RefusesAFileThatIsNone) {
  const TemporaryFolder folder;
  WriteFileAtomically(folder / "text.sqlite", "this is not a database, but long enough to be read");
  EXPECT_THROW(Ledger(folder / "text.sqlite", Ledger::Mode::read_write), InputError);
  EXPECT_THROW(Ledger(folder / "absent.sqlite", Ledger::Mode::read_only), InputError);
}

TEST(Ledger, KeepsTheFidelityOfCandidatesAndWhatWasTold) {
  const TemporaryFolder folder;
  Ledger ledger(folder / "ledger.sqlite", Ledger::Mode::read_write);
  ledger.AddAsk(1, {{.candidate = {.id = 0, .point = Eigen::VectorXd::Zero(1), .fidelity = 0.5}}});
  ledger.AddTell({.id = 0, .point = Eigen::VectorXd::Zero(1), .fidelity = 0.5}, 1);
  EXPECT_EQ(ledger.Candidates().at(0).candidate.fidelity, 0.5);
  EXPECT_EQ(ledger.Events().at(1).observation->fidelity, 0.5);
}

// As the program wrote it before candidates had a fidelity.
TEST(Ledger, ReadsAndUpgradesTheFirstSchema) {
  const TemporaryFolder folder;
  const std::filesystem::path file = folder / "ledger.sqlite";
  Ledger(file, Ledger::Mode::read_write)
      .AddAsk(1, {{.candidate = {.id = 0, .point = Eigen::VectorXd::Zero(1)}}});
  {
    SQLite::Database database(file.string(), SQLite::OPEN_READWRITE);
    database.exec("ALTER TABLE candidates DROP COLUMN fidelity");
    database.exec("PRAGMA user_version = 1");
  }
  EXPECT_EQ(Ledger(file, Ledger::Mode::read_only).Candidates().at(0).candidate.fidelity, 1);
  EXPECT_EQ(SQLite::Database(file.string()).execAndGet("PRAGMA user_version").getInt(), 1)
      << "reading changes nothing";
  Ledger ledger(file, Ledger::Mode::read_write);
  ledger.AddAsk(1, {{.candidate = {.id = 1, .point = Eigen::VectorXd::Zero(1), .fidelity = 0.5}}});
  EXPECT_EQ(ledger.Candidates().at(0).candidate.fidelity, 1);
  EXPECT_EQ(ledger.Candidates().at(1).candidate.fidelity, 0.5);
  EXPECT_EQ(SQLite::Database(file.string()).execAndGet("PRAGMA user_version").getInt(), 2);
}

TEST(Ledger, SumsTimesOverSessions) {
  const TemporaryFolder folder;
  Ledger ledger(folder / "ledger.sqlite", Ledger::Mode::read_write);
  const auto first = ledger.StartSession();
  ledger.UpdateSession(first, {1, 0.5});
  ledger.UpdateSession(first, {10, 1});
  ledger.UpdateSession(ledger.StartSession(), {5, 0.25});
  EXPECT_EQ(ledger.TotalTimes().wall, 15);
  EXPECT_EQ(ledger.TotalTimes().overhead, 1.25);
}

}  // namespace
}  // namespace powdercal
