#include "backends/embedded/embedded.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <nlohmann/json.hpp>
#include <thread>

#include "backends/embedded/kernels.h"
#include "core/errors.h"
#include "tests/support/program.h"

// The embedded engine as a backend: options, files, several runs at a time. What it computes is the
// matter of tests/physics.

namespace powdercal {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
namespace fs = std::filesystem;

std::unique_ptr<Backend> With(const std::string& options) {
  auto backend = MakeEmbeddedBackend();
  ReadYaml(options, "s.yaml", [&](Archive& archive) { backend->Serialize(archive); });
  return backend;
}

std::string ErrorOf(const std::string& options) {
  try {
    With(options)->Prepare({});
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

// Some spheres that fall on a floor.
Program Fall(std::uint64_t seed) {
  Program program;
  program.experiment = "fall";
  program.particles.sizes = {SizeDistribution::Kind::monodisperse, 30e-6};
  program.particles.count = 60;
  program.particles.seed = seed;
  program.materials = {.density = 8220, .young_modulus = 5e6, .poisson_ratio = 0.3};
  program.materials.particle_particle = {.restitution = 0.4, .friction = 0.3};
  program.materials.particle_wall = program.materials.particle_particle;
  program.domain = {{0, 0, -3e-5}, {1.5e-4, 1.5e-4, 2e-3}, {}};
  program.domain.boundaries = {Boundary::periodic, Boundary::periodic, Boundary::open};
  program.walls = {{.name = "floor", .axis = 2, .position = 0, .facing_positive = true}};
  program.gravity = {0, 0, -9.81};
  program.time_step = 2e-7;
  program.stages = {Insert{.bottom = 0, .top = 3e-4, .velocity = {0, 0, -0.05}},
                    Advance{.name = "fall", .duration = 1e-3}};
  return program;
}

TEST(Embedded, IsAlwaysThereAndSaysHowItRuns) {
  const auto backend = MakeEmbeddedBackend();
  EXPECT_TRUE(backend->availability().available);
  EXPECT_TRUE(backend->writes_snapshots());
  const std::string best(embedded::IsaNames()[static_cast<std::size_t>(embedded::BestIsa())]);
  EXPECT_EQ(backend->Describe(), "built in, " + best + ", 1 thread");
  EXPECT_EQ(backend->cores(), 1);
  EXPECT_EQ(With("{isa: portable, threads: 2}")->Describe(), "built in, portable, 2 threads");
  EXPECT_EQ(With("threads: 2")->cores(), 2);
}

TEST(Embedded, OptionsDoNotChangeTheFingerprint) {
  EXPECT_EQ(With("{isa: portable, threads: 2}")->Fingerprint(),
            MakeEmbeddedBackend()->Fingerprint());
}

TEST(Embedded, RefusesOptionsOutOfRange) {
  EXPECT_EQ(ErrorOf("threads: 0"), "s.yaml:1:10: threads: must lie in [1, 256] (found '0')");
  EXPECT_THAT(ErrorOf("isa: sse9"), HasSubstr("unknown instruction set 'sse9' (valid: auto, "));
}

TEST(Embedded, RefusesAnInstructionSetThatTheProcessorDoesNotHave) {
  for (const embedded::Isa isa :
       {embedded::Isa::portable, embedded::Isa::avx2, embedded::Isa::avx512}) {
    const std::string name = embedded::IsaNames()[static_cast<std::size_t>(isa)];
    EXPECT_EQ(ErrorOf("isa: " + name),
              embedded::Has(isa) ? ""
                                 : "backend.isa: this processor does not have the instruction set "
                                   "(found '" +
                                       name + "')");
  }
}

TEST(Embedded, WarnsOfMoreThreadsThanCores) {
  EXPECT_THAT(MakeEmbeddedBackend()->Prepare({}), IsEmpty());
  const unsigned cores = std::thread::hardware_concurrency();
  if (cores == 0 || cores >= 256) GTEST_SKIP() << cores << " cores";
  EXPECT_THAT(With("threads: " + std::to_string(cores + 1))->Prepare({}),
              ElementsAre(HasSubstr(fmt::format("{} threads on {} cores", cores + 1, cores))));
}

TEST(Embedded, RunsAtTheSameTimeDoNotDisturbEachOther) {
  constexpr int kRuns = 6;
  const auto backend = MakeEmbeddedBackend();
  const auto run = [&](int seed) {
    return backend->Run(Fall(static_cast<std::uint64_t>(seed)), {}).moments.at(0).packing;
  };
  std::vector<Packing> together(kRuns);
  {
    std::vector<std::jthread> threads;
    for (int n = 0; n < kRuns; ++n) {
      threads.emplace_back([&, n] { together[static_cast<std::size_t>(n)] = run(n); });
    }
  }
  for (int n = 0; n < kRuns; ++n) {
    const Packing alone = run(n);
    const Packing& other = together[static_cast<std::size_t>(n)];
    ASSERT_EQ(other.size(), alone.size());
    for (std::size_t p = 0; p < alone.size(); ++p) {
      EXPECT_EQ(other[p].position, alone[p].position) << n;
      EXPECT_EQ(other[p].velocity, alone[p].velocity) << n;
    }
  }
}

TEST(Embedded, KeepsFilesOfFailuresOnly) {
  const TemporaryFolder folder;
  const auto backend = MakeEmbeddedBackend();
  EXPECT_TRUE(backend->Run(Fall(1), {.work_folder = folder / "good"}).outcome.ok());
  EXPECT_FALSE(fs::exists(folder / "good"));

  Program program = Fall(1);
  std::get<Advance>(program.stages.at(1)).duration = 100;
  const Trace trace = backend->Run(
      program, {.work_folder = folder / "bad", .time_limit = std::chrono::milliseconds(50)});
  EXPECT_EQ(trace.outcome.reason, Reason::timeout);
  EXPECT_THAT(ReadFile(folder / "bad/outcome.txt"),
              HasSubstr(ToString(trace.outcome.reason) + ": " + trace.outcome.message));
  EXPECT_EQ(ReadJson(folder / "bad/program.json"), program.ToJson());
  EXPECT_TRUE(fs::exists(folder / "bad" / kSnapshotFolder / "particles.pvd"));
}

TEST(Embedded, SnapshotsAreKeptAndChangeNothing) {
  const TemporaryFolder folder;
  const auto backend = MakeEmbeddedBackend();
  const Trace plain = backend->Run(Fall(1), {});
  const Trace shown = backend->Run(
      Fall(1), {.work_folder = folder / "x", .keep_files = true, .snapshot_interval = 2e-4});
  EXPECT_EQ(shown.moments.at(0).packing.at(7).position, plain.moments.at(0).packing.at(7).position);
  int files = 0;
  for (const auto& entry : fs::directory_iterator(folder / "x" / kSnapshotFolder)) {
    files += entry.path().filename().string().starts_with("particles") &&
             entry.path().extension() == ".vtp";
  }
  EXPECT_EQ(files, 6) << "the beginning, and every 0.2 ms of 1 ms";
}

}  // namespace
}  // namespace powdercal
