#include "studies/comparison/oracle.h"

#include "studies/evaluation.h"

namespace powdercal::comparison {
namespace {

class EmulatorOracle final : public Oracle {
 public:
  explicit EmulatorOracle(const Emulator& emulator) : emulator_(emulator) {}

  LedgerRun Simulate(std::size_t experiment, const Eigen::VectorXd& point, int replicate,
                     const RandomStream& world) const override {
    return emulator_.Simulate(experiment, point, replicate, world);
  }
  Eigen::VectorXd Truth(const Eigen::VectorXd& point) const override {
    return emulator_.Truth(point);
  }
  bool noisy() const override { return true; }
  std::string fingerprint() const override { return emulator_.fingerprint(); }

 private:
  const Emulator& emulator_;
};

class TableOracle final : public Oracle {
 public:
  explicit TableOracle(const Planner& planner)
      : planner_(planner), objectives_(planner.study().MakeObjectives()) {}

  LedgerRun Simulate(std::size_t experiment, const Eigen::VectorXd& point, int replicate,
                     const RandomStream&) const override {
    const Eigen::VectorXd values = planner_.study().space.FromUnit(point);
    LedgerRun run = planner_.Execute(
        planner_.PlanExperiment(experiment, {values.begin(), values.end()}, replicate), {});
    run.diagnostics.wall_seconds = run.total_seconds = 1;
    return run;
  }
  Eigen::VectorXd Truth(const Eigen::VectorXd& point) const override {
    std::vector<LedgerRun> runs;
    for (const std::size_t i : planner_.study().CalibratedExperiments()) {
      runs.push_back(Simulate(i, point, 0, RandomStream(0)));
    }
    std::vector<const LedgerRun*> pointers;
    for (const LedgerRun& run : runs) pointers.push_back(&run);
    return Reduce(objectives_, pointers).means;
  }
  bool noisy() const override { return false; }
  std::string fingerprint() const override { return planner_.backend().Fingerprint(); }

 private:
  const Planner& planner_;
  Objectives objectives_;
};

}  // namespace

std::unique_ptr<Oracle> MakeEmulatorOracle(const Emulator& emulator) {
  return std::make_unique<EmulatorOracle>(emulator);
}

std::unique_ptr<Oracle> MakeTableOracle(const Planner& planner) {
  return std::make_unique<TableOracle>(planner);
}

}  // namespace powdercal::comparison
