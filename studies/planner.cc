#include "studies/planner.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>

#include "backends/registry.h"
#include "backends/servo_gain.h"
#include "core/hash.h"
#include "core/random.h"

namespace powdercal {
namespace {

// Replicates of different points use different particles, so that a lucky arrangement cannot favour
// a whole region; the same point always gets the same ones, so that the ledger can serve it again.
std::uint64_t ParticleSeed(const Study& study, const std::vector<double>& parameters,
                           int replicate) {
  RandomStream stream = RandomStream(study.seed).Split("particles");
  for (const double value : parameters) stream = stream.Split(std::bit_cast<std::uint64_t>(value));
  // 31 bits suit every simulator.
  return stream.Split(static_cast<std::uint64_t>(replicate)).Bits() >> 33;
}

Conditions::Cohesion LawOf(const ContactLaw& law) {
  switch (law.cohesion) {
    case ContactLaw::Cohesion::sjkr2:
      return Conditions::Cohesion::sjkr2;
    case ContactLaw::Cohesion::dmt:
      return Conditions::Cohesion::dmt;
    case ContactLaw::Cohesion::none:
      break;
  }
  return Conditions::Cohesion::none;
}

}  // namespace

Planner::Planner(const Study& study)
    : Planner(study, *study.scaling, *study.backend.backend, Law::simulated) {}

Planner::Planner(const Study& study, const Scaling& scaling)
    : Planner(study, scaling, *study.backend.backend, Law::simulated) {}

Planner::Planner(const Study& study, Fidelity limit) : Planner(study) { limit_ = limit; }

Planner::Planner(const Study& study, const Backend& backend, Law law)
    : Planner(study, *study.scaling, backend, law) {}

Planner::Planner(const Study& study, const Scaling& scaling, const Backend& backend, Law law)
    : study_(study),
      scaling_(scaling),
      backend_(backend),
      law_(law),
      availability_(backend.availability()) {
  for (std::size_t i = 0; i < study.experiments.size(); ++i) {
    const std::optional<double> stress = Laboratory(i).stress;
    if (stress) largest_stress_ = std::max(largest_stress_.value_or(0), *stress);
  }
}

Fidelity Planner::FidelityOf(std::size_t experiment) const {
  const Fidelity own = study_.FidelityOf(experiment);
  return limit_ ? std::min(own, *limit_) : own;
}

Conditions Planner::Laboratory(std::size_t experiment) const {
  const PowderSpecification& powder = study_.powder;
  Conditions conditions{.study_stress = largest_stress_,
                        .young_modulus = powder.young_modulus,
                        .poisson_ratio = powder.poisson_ratio,
                        .density = powder.density,
                        .diameter = powder.sizes.Moment(1),
                        .gravity = 9.81,
                        .surface_energy = powder.surface_energy,
                        .restitution = powder.restitution,
                        .friction = powder.particle_friction,
                        .wall_friction = powder.wall_friction,
                        .law_of_cohesion = LawOf(study_.law)};
  study_.experiments[experiment].experiment->DescribeConditions(FidelityOf(experiment), conditions);
  return conditions;
}

Conditions Planner::Simulation(std::size_t experiment,
                               const std::vector<double>& parameters) const {
  Conditions simulation = scaling_.ToSimulation(Laboratory(experiment));
  const SimulatedPowder powder = MakePowder(simulation, parameters);
  const ContactParameters& contact = powder.materials.particle_particle;
  simulation.cohesion_energy_density.reset();
  simulation.surface_energy.reset();
  if (powder.law.cohesion == ContactLaw::Cohesion::sjkr2) {
    simulation.cohesion_energy_density = contact.cohesion_energy_density;
  } else if (powder.law.cohesion == ContactLaw::Cohesion::dmt) {
    simulation.surface_energy = contact.surface_energy;
  } else {
    simulation.cohesion_energy_density = 0;
  }
  simulation.restitution = contact.restitution;
  simulation.friction = contact.friction;
  simulation.wall_friction = powder.materials.particle_wall.friction;
  simulation.rolling_friction = contact.rolling_friction;
  simulation.directional_torque = powder.law.rolling == ContactLaw::Rolling::cdt;
  simulation.time_step = study_.numerics.TimeStep(powder);
  const Materials& materials = powder.materials;
  simulation.rayleigh_time = RayleighTime(powder.sizes.Quantile(0) / 2, materials.density,
                                          materials.young_modulus, materials.poisson_ratio);
  study_.experiments[experiment].experiment->DescribeSimulation(powder, FidelityOf(experiment),
                                                                simulation);
  return simulation;
}

SimulatedPowder Planner::MakePowder(const Conditions& simulation,
                                    const std::vector<double>& parameters) const {
  const PowderSpecification& known = study_.powder;
  SimulatedPowder powder{.sizes = known.sizes, .materials = {}, .law = study_.law};
  Materials& materials = powder.materials;
  materials.density = *simulation.density;
  materials.young_modulus = *simulation.young_modulus;
  materials.poisson_ratio = *simulation.poisson_ratio;
  materials.particle_particle = {.restitution = known.restitution,
                                 .friction = known.particle_friction,
                                 .rolling_friction = known.rolling_friction,
                                 .cohesion_energy_density = known.cohesion_energy_density,
                                 .surface_energy = known.surface_energy.value_or(0)};
  if (scaling_.scales_cohesion()) {
    ContactParameters& contact = materials.particle_particle;
    contact.surface_energy = simulation.surface_energy.value_or(0);
    if (known.cohesion_energy_density == 0) {
      contact.cohesion_energy_density = simulation.cohesion_energy_density.value_or(0);
    }
  }
  materials.particle_wall = materials.particle_particle;
  materials.particle_wall.friction = known.wall_friction;
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    ApplyParameter(study_.space.parameters[i], parameters[i], powder);
  }
  if (law_ == Law::simulated) study_.approximations.Apply(powder);
  return powder;
}

std::string Planner::ExplainUnplanned(std::size_t experiment) const {
  const StudyExperiment& entry = study_.experiments[experiment];
  std::string reason = scaling_.ExplainUnsupported(Laboratory(experiment));
  if (!reason.empty()) {
    return fmt::format("scaling '{}' of {}: {}", scaling_.name(), entry.name(), reason);
  }
  for (const std::vector<double>& centre : Centres()) {
    reason =
        entry.experiment->ExplainUnsupported(MakePowder(Simulation(experiment, centre), centre));
    if (!reason.empty()) return fmt::format("{}: {}", entry.name(), reason);
  }
  return "";
}

PlannedRun Planner::PlanExperiment(std::size_t experiment, const std::vector<double>& parameters,
                                   int replicate, std::optional<std::uint64_t> seed) const {
  const Experiment& test = *study_.experiments[experiment].experiment;
  const Conditions simulation = Simulation(experiment, parameters);
  PlannedRun run{.experiment = experiment, .replicate = replicate};
  run.seed = seed.value_or(ParticleSeed(study_, parameters, replicate));
  run.program = test.Plan(MakePowder(simulation, parameters), simulation, study_.numerics,
                          FidelityOf(experiment), run.seed);
  run.program.experiment = test.name();
  for (std::size_t p = 0; p < parameters.size(); ++p) {
    run.program.parameters[study_.space.parameters[p].name] = parameters[p];
  }
  run.program_hash = run.program.Hash();
  run.key = Sha256(fmt::format("{}\n{}\n{}\n{}", run.program_hash, backend_.name(),
                               availability_.version, backend_.Fingerprint()));
  return run;
}

std::vector<PlannedRun> Planner::Plan(const std::vector<double>& parameters, int replicate) const {
  std::vector<PlannedRun> runs;
  for (const std::size_t i : study_.CalibratedExperiments()) {
    runs.push_back(PlanExperiment(i, parameters, replicate));
  }
  return runs;
}

std::vector<double> Planner::Centre() const {
  const Eigen::VectorXd middle = Eigen::VectorXd::Constant(study_.space.dimension(), 0.5);
  const Eigen::VectorXd values = study_.space.FromUnit(middle);
  return {values.begin(), values.end()};
}

std::vector<std::vector<double>> Planner::Centres() const {
  std::vector<std::vector<double>> centres = {Centre()};
  for (std::size_t i = 0; i < study_.space.parameters.size(); ++i) {
    const Parameter& parameter = study_.space.parameters[i];
    if (!parameter.categorical()) continue;
    std::vector<std::vector<double>> more;
    for (const std::vector<double>& centre : centres) {
      for (int level = 0; level < parameter.levels(); ++level) {
        more.push_back(centre);
        more.back()[i] = level;
      }
    }
    centres = std::move(more);
  }
  return centres;
}

std::vector<std::string> Planner::Warnings(const std::vector<std::size_t>& evaluate_also) const {
  std::vector<std::string> warnings = study_.warnings;
  std::vector<std::size_t> experiments = study_.CalibratedExperiments();
  experiments.insert(experiments.end(), evaluate_also.begin(), evaluate_also.end());
  if (!backend_.simulates() || !ExplainUnsupported(experiments).empty()) {
    return warnings;
  }
  for (const std::size_t i : experiments) {
    const Program program = PlanExperiment(i, Centre(), 0).program;
    const Materials& m = program.materials;
    const double fraction =
        program.time_step / RayleighTime(study_.powder.sizes.Quantile(0) / 2, m.density,
                                         m.young_modulus, m.poisson_ratio);
    if (fraction <= 0.4) continue;
    warnings.push_back(
        fmt::format("{}: the time step is {:.2g} Rayleigh times of the smallest "
                    "particle; beyond 0.4 runs blow up",
                    program.experiment, fraction));
  }
  // What experiments warn of, chatter of rolling friction, is worst where that is largest.
  for (std::vector<double> parameters : Centres()) {
    for (std::size_t i = 0; i < parameters.size(); ++i) {
      const Parameter& parameter = study_.space.parameters[i];
      if (parameter.name == "rolling_friction") parameters[i] = parameter.upper;
    }
    for (const std::size_t i : experiments) {
      const Program program = PlanExperiment(i, parameters, 0).program;
      for (std::string& text : study_.experiments[i].experiment->Warnings(program)) {
        if (std::find(warnings.begin(), warnings.end(), text) == warnings.end()) {
          warnings.push_back(std::move(text));
        }
      }
    }
  }
  return warnings;
}

std::string Planner::ExplainUnsupported() const {
  return ExplainUnsupported(study_.CalibratedExperiments());
}

std::string Planner::ExplainUnsupported(const std::vector<std::size_t>& experiments) const {
  for (const std::size_t i : experiments) {
    if (const std::string reason = ExplainUnplanned(i); !reason.empty()) return reason;
  }
  std::vector<Conditions> all;
  for (std::size_t i = 0; i < study_.experiments.size(); ++i) all.push_back(Laboratory(i));
  if (const std::string reason = scaling_.ExplainWithoutEffect(all); !reason.empty()) {
    return fmt::format("scaling '{}': {}", scaling_.name(), reason);
  }
  for (const std::size_t i : experiments) {
    if (const std::string reason = ExplainBackend(i); !reason.empty()) {
      return fmt::format("backend '{}' cannot run {}: {}", backend_.name(),
                         study_.experiments[i].name(), reason);
    }
  }
  return "";
}

// Requires ExplainUnplanned() == "".
std::string Planner::ExplainBackend(std::size_t experiment) const {
  for (const std::vector<double>& centre : Centres()) {
    const std::string reason =
        backend_.ExplainUnsupported(PlanExperiment(experiment, centre, 0).program);
    if (!reason.empty()) return reason;
  }
  return "";
}

std::vector<std::string> Planner::ConfirmationWarnings() const {
  std::vector<std::string> warnings;
  for (const auto& other : study_.backend.confirm_with) {
    const Planner planner(study_, *other);
    if (!planner.availability_.available) {
      warnings.push_back(fmt::format("{} will not confirm the best point: it is not available, {}",
                                     other->name(), planner.availability_.why_not));
      continue;
    }
    for (const std::size_t i : study_.CalibratedExperiments()) {
      if (!ExplainUnplanned(i).empty()) continue;
      const std::string reason = planner.ExplainBackend(i);
      if (reason.empty()) continue;
      warnings.push_back(fmt::format("{} will not confirm the best point in {}: {}", other->name(),
                                     study_.experiments[i].name(), reason));
    }
  }
  return warnings;
}

LedgerRun Planner::Execute(const PlannedRun& run, const RunContext& context) const {
  const auto elapsed = [start = std::chrono::steady_clock::now()] {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  };
  LedgerRun result{.key = run.key,
                   .experiment = run.program.experiment,
                   .program_hash = run.program_hash,
                   .seed = run.seed,
                   .backend = backend_.name(),
                   .backend_version = availability_.version,
                   .fidelity = ToString(run.program.fidelity)};
  if (!availability_.available) {
    result.outcome = {Reason::unsupported, "not available: " + availability_.why_not};
    return result;
  }
  try {
    const Trace trace = backend_.Run(run.program, context);
    result.outcome = trace.outcome;
    result.diagnostics = trace.diagnostics;
    if (trace.outcome.ok()) {
      Measurement measurement = study_.experiments[run.experiment].experiment->Measure(
          run.program, trace, &result.outcome);
      if (result.outcome.ok())
        result.measurement = std::move(measurement);
      else
        result.measurement.diagnostics = std::move(measurement.diagnostics);
    }
  } catch (const std::exception& error) {
    // Memory or a disk that ran out, a folder that vanished: the run failed, the study goes on.
    result.outcome = {Reason::crashed, error.what()};
    if (result.diagnostics.wall_seconds == 0) result.diagnostics.wall_seconds = elapsed();
  }
  for (const auto& [name, response] : result.measurement.responses) {
    if (!std::isfinite(response.value)) {
      result.outcome = {Reason::unstable, fmt::format("response {} is not finite", name)};
      result.measurement.responses.clear();
      break;
    }
  }
  result.total_seconds = elapsed();
  return result;
}

Planner::ExperimentCost Planner::CostOf(std::size_t experiment, int runs) const {
  ExperimentCost one{.experiment = experiment, .runs = runs};
  if (!ExplainUnplanned(experiment).empty()) return one;
  const Program program = PlanExperiment(experiment, Centre(), 0).program;
  one.particles = program.particles.packing ? static_cast<int>(program.particles.packing->size())
                                            : program.particles.count;
  one.steps =
      study_.experiments[experiment].experiment->ExpectedDuration(program) / program.time_step;
  const double throughput = backend_.Throughput(program);
  if (throughput > 0) one.seconds = one.steps * one.particles / throughput;
  return one;
}

Planner::Cost Planner::EstimateCost(const std::vector<std::size_t>& evaluate_also) const {
  const BackendSpecification& backend = study_.backend;
  Cost cost;
  const auto add = [&cost](std::vector<ExperimentCost>& list, const ExperimentCost& one) {
    list.push_back(one);
    cost.runs += one.runs;
    cost.steps_per_run += one.runs * one.steps;
    cost.seconds_per_run += one.runs * one.seconds;
  };
  const int calibration = study_.budget.evaluations * backend.replicates +
                          backend.confirm_replicates - backend.replicates;
  for (const std::size_t i : study_.CalibratedExperiments()) {
    add(cost.experiments, CostOf(i, calibration));
  }
  for (const std::size_t i : evaluate_also) {
    add(cost.experiments, CostOf(i, backend.confirm_replicates));
  }
  for (const auto& other : backend.confirm_with) {
    const Planner planner(study_, *other);
    ConfirmationCost& confirmation = cost.confirmations.emplace_back();
    confirmation.backend = other->name();
    if (!planner.availability_.available) continue;
    for (const std::size_t i : study_.CalibratedExperiments()) {
      if (!ExplainUnplanned(i).empty() || !planner.ExplainBackend(i).empty()) continue;
      add(confirmation.experiments, planner.CostOf(i, backend.confirm_replicates));
    }
  }
  if (study_.approximations.any()) {
    const bool own = study_.backend.backend->name() == kReferenceBackend;
    const auto reference = MakeBackend(kReferenceBackend);
    const Planner planner(study_, own ? *study_.backend.backend : *reference, Law::exact);
    for (const std::size_t i : study_.CalibratedExperiments()) {
      add(cost.approximation, planner.CostOf(i, (own ? 1 : 2) * backend.confirm_replicates));
    }
  }
  cost.seconds = cost.seconds_per_run / study_.parallel();
  cost.steps_per_run /= cost.runs;
  cost.seconds_per_run /= cost.runs;
  return cost;
}

std::vector<ScalingTable> Planner::ScalingTables(const std::vector<std::size_t>& experiments,
                                                 const std::vector<double>& parameters) const {
  std::vector<ScalingTable> tables;
  for (const std::size_t i : experiments) {
    if (!ExplainUnplanned(i).empty()) continue;
    const std::string& name = study_.experiments[i].name();
    ScalingTable table{
        .experiment = name, .laboratory = Laboratory(i), .simulation = Simulation(i, parameters)};
    const Program program = PlanExperiment(i, parameters, 0).program;
    for (const Stage& stage : program.stages) {
      if (const auto* servo = std::get_if<Servo>(&stage)) {
        table.simulation.servo_gain =
            std::max(table.simulation.servo_gain.value_or(0), ServoGain(program, *servo));
      }
    }
    table.groups = CompareGroups(table.laboratory, table.simulation, name);
    table.cohesion = ReadBack(name, table.laboratory, table.simulation);
    tables.push_back(std::move(table));
  }
  return tables;
}

}  // namespace powdercal
