#include "experiments/shear.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "core/errors.h"
#include "core/quantity.h"
#include "experiments/shear_series.h"
#include "experiments/steady_state.h"
#include "experiments/yield_locus.h"
#include "scaling/groups.h"

namespace powdercal {
namespace {

constexpr double kAgreement = 0.05;  // of stresses that must be equal in steady state
constexpr double kMatch = 0.01;      // of normal stresses of study and file
constexpr double kChiLimit = 0.05;
constexpr std::size_t kFewestSamples = 40;
// Strain that counts as one independent sample of stress or density, as long runs show; a run of a
// strain or two sees less of it.
constexpr double kMemoryStrain = 0.3;

struct CellSize {
  int count = 0;
  double width = 0;            // [d]
  double inertial_number = 0;  // [-]
  double preshear_strain = 0;  // [-]
};

CellSize SizeOf(Fidelity fidelity) {
  switch (fidelity) {
    case Fidelity::quick:
      return {1000, 10, 4e-3, 2.4};
    case Fidelity::standard:
      return {3000, 14.4, 2e-3, 3};
    case Fidelity::paper:
      break;
  }
  return {10'000, 21.5, 1e-3, 3};
}

std::string ShearStressName(std::size_t index) { return fmt::format("shear_stress_{}", index + 1); }

// The simulation's preshear.
double PreshearStress(const Program& program) {
  for (const Stage& stage : program.stages) {
    if (const Deform* deform = std::get_if<Deform>(&stage)) return deform->edges[2].value;
    if (const Servo* servo = std::get_if<Servo>(&stage)) return servo->stress;
  }
  return 0;
}

template <typename Member>
std::vector<double> Values(std::span<const ShearSample> samples, const Member& member) {
  std::vector<double> values;
  for (const ShearSample& sample : samples) values.push_back(member(sample));
  return values;
}

double ShearOf(const ShearSample& sample) { return sample.stress.shear; }
double VoidRatioOf(const ShearSample& sample) { return sample.void_ratio; }

// The steady part of the preshear.
struct Steady {
  std::span<const ShearSample> samples;
  ShearSample mean;
  double friction = 0;             // [-] tau/sigma
  double friction_variance = 0;    // [-]
  double void_ratio_variance = 0;  // [-]
};

Steady MeasureSteady(std::span<const ShearSample> samples) {
  Steady steady{.samples = samples, .mean = MeanSample(samples)};
  steady.friction = steady.mean.stress.shear / steady.mean.stress.normal;
  const std::vector<double> residuals = Values(samples, [&](const ShearSample& s) {
    return s.stress.shear - steady.friction * s.stress.normal;
  });
  steady.friction_variance =
      MeanOf(residuals).variance / (steady.mean.stress.normal * steady.mean.stress.normal);
  steady.void_ratio_variance = MeanOf(Values(samples, VoidRatioOf)).variance;
  return steady;
}

// "" or what is wrong with the steady state's stresses.
std::string ExplainDisagreement(const Program& program, const Steady& steady,
                                std::map<std::string, double>* notes) {
  const ShearSample& mean = steady.mean;
  const double target = PreshearStress(program);
  (*notes)["stress_ratio"] = mean.stress.normal / target;
  (*notes)["asymmetry"] = mean.complementary / mean.bulk.shear - 1;
  if (std::abs(mean.stress.normal / target - 1) > kAgreement) {
    return fmt::format("the mean normal stress of the preshear is {:.4g} Pa instead of {:.4g} Pa",
                       mean.stress.normal, target);
  }
  if (std::abs(mean.complementary - mean.bulk.shear) > kAgreement * mean.bulk.normal) {
    return fmt::format(
        "the stress tensor is not symmetric: its shear stresses are {:.4g} Pa and "
        "{:.4g} Pa",
        mean.bulk.shear, mean.complementary);
  }
  if (program.meshes.empty()) return "";
  const std::array<std::pair<const char*, StressPair>, 3> places = {
      std::pair{"top", mean.stress}, {"bottom", mean.bottom}, {"bulk", mean.bulk}};
  for (const auto& [place, pair] : places) {
    (*notes)[fmt::format("normal_stress_{}", place)] = pair.normal;
    (*notes)[fmt::format("shear_stress_{}", place)] = pair.shear;
  }
  for (double StressPair::*stress : {&StressPair::normal, &StressPair::shear}) {
    const auto [least, most] =
        std::minmax({mean.stress.*stress, mean.bottom.*stress, mean.bulk.*stress});
    if (most - least <= kAgreement * target) continue;
    return fmt::format(
        "the {} stresses at the top ({:.4g} Pa), at the bottom ({:.4g} Pa) and in the powder "
        "({:.4g} Pa) differ by more than {:.0f} % of the normal stress",
        stress == &StressPair::normal ? "normal" : "shear", mean.stress.*stress,
        mean.bottom.*stress, mean.bulk.*stress, 100 * kAgreement);
  }
  return "";
}

// Yield points by normal stress and presheared state, in the simulation's stresses.
using YieldTable = std::vector<std::vector<StressPair>>;

// "" or which yield stress was never reached.
std::string ReadYields(const ShearRecord& record, const std::vector<double>& normals,
                       double friction, YieldTable* table) {
  table->assign(normals.size(), {});
  for (const std::vector<ShearSeries>& state : record.yields) {
    if (state.size() != normals.size()) return "the trace lacks yield points";
    for (std::size_t i = 0; i < normals.size(); ++i) {
      const YieldPoint point = FindYieldPoint(state[i], normals[i], friction);
      if (!point.reached) {
        return fmt::format(
            "the normal stress was never within {:.0f} % of {:.4g} Pa over a strain of {:g} (at "
            "last {:.4g} Pa)",
            100 * kNormalStressTolerance, normals[i], kYieldWindow, state[i].back().stress.normal);
      }
      (*table)[i].push_back(point.stress);
    }
  }
  return "";
}

// Pooled relative sd of the shear stress among the states; 0 for a single one.
double RelativeScatter(const YieldTable& table) {
  double squares = 0;
  double freedom = 0;
  for (const std::vector<StressPair>& points : table) {
    double mean = 0;
    for (const StressPair& point : points) mean += point.shear / static_cast<double>(points.size());
    for (const StressPair& point : points) {
      squares += (point.shear / mean - 1) * (point.shear / mean - 1);
    }
    freedom += static_cast<double>(points.size()) - 1;
  }
  return freedom > 0 ? std::sqrt(squares / freedom) : 0;
}

// Multiplies each state's points by the steady tau/sigma over that of the state.
void Prorate(const ShearRecord& record, double friction, YieldTable* table) {
  for (std::size_t j = 0; j < record.states.size(); ++j) {
    const std::span<const ShearSample> before(record.preshear.data(), record.states[j]);
    std::size_t first = before.size() - 1;
    while (first > 0 && before.back().strain - before[first - 1].strain < kYieldWindow) --first;
    const StressPair state = MeanSample(before.subspan(first)).stress;
    for (std::vector<StressPair>& points : *table) {
      points[j].shear *= friction * state.normal / state.shear;
    }
  }
}

// The mean points, with their sds where there are several states.
std::vector<ShearPoint> MeanPoints(const YieldTable& table) {
  const double scatter = RelativeScatter(table);
  std::vector<ShearPoint> means;
  for (const std::vector<StressPair>& points : table) {
    const auto n = static_cast<double>(points.size());
    ShearPoint mean;
    for (const StressPair& point : points) {
      mean.normal += point.normal / n;
      mean.shear += point.shear / n;
    }
    mean.shear_sd = scatter * std::abs(mean.shear) / std::sqrt(n);
    means.push_back(mean);
  }
  return means;
}

// Takes the covariance of the locus from the lines of the single states: their points are not
// independent, for they share a state.
void TakeScatterOfStates(const YieldTable& table, LinearLocus* locus) {
  const std::size_t states = table.front().size();
  if (states < 2) return;
  const auto n = static_cast<double>(states);
  std::vector<LinearLocus> lines;
  LinearLocus mean;
  for (std::size_t j = 0; j < states; ++j) {
    std::vector<ShearPoint> points;
    for (const std::vector<StressPair>& row : table) {
      points.push_back({row[j].normal, row[j].shear, 0, std::abs(row[j].shear)});
    }
    lines.push_back(FitLocus(points));
    mean.cohesion += lines.back().cohesion / n;
    mean.tan_phi += lines.back().tan_phi / n;
  }
  locus->cohesion_variance = locus->tan_phi_variance = locus->covariance = 0;
  const double weight = 1 / (n * (n - 1));
  for (const LinearLocus& line : lines) {
    const double c = line.cohesion - mean.cohesion;
    const double t = line.tan_phi - mean.tan_phi;
    locus->cohesion_variance += weight * c * c;
    locus->tan_phi_variance += weight * t * t;
    locus->covariance += weight * c * t;
  }
}

const char* NameOf(ShearWarning::Kind kind) {
  switch (kind) {
    case ShearWarning::Kind::too_few_points:
      return "too_few_points";
    case ShearWarning::Kind::sds_ignored:
      return "sds_ignored";
    case ShearWarning::Kind::cohesion_not_positive:
      return "cohesion_not_positive";
    case ShearWarning::Kind::cohesion_not_significant:
      return "cohesion_not_significant";
    case ShearWarning::Kind::friction_not_positive:
      return "friction_not_positive";
    case ShearWarning::Kind::preshear_above_locus:
      return "preshear_above_locus";
    case ShearWarning::Kind::tension:
      return "tension";
    case ShearWarning::Kind::locus_not_concave:
      return "locus_not_concave";
    case ShearWarning::Kind::locus_curved:
      return "locus_curved";
    case ShearWarning::Kind::beyond_preshear:
      return "beyond_preshear";
    case ShearWarning::Kind::below_unconfined_circle:
      break;
  }
  return "below_unconfined_circle";
}

double Variance(double sd) { return std::isfinite(sd) ? sd * sd : 0; }

// Responses of the locus and the steady state; `unit` is the laboratory's stress over the
// simulation's.
void AddResponses(const std::vector<double>& normals, const YieldTable& table, const Steady& steady,
                  double preshear, double unit, Measurement* measurement) {
  const std::vector<ShearPoint> points = MeanPoints(table);
  LinearLocus locus = FitLocus(points);
  TakeScatterOfStates(table, &locus);
  const double friction_sd = std::sqrt(steady.friction_variance);
  const ShearPoint reference = {preshear, std::max(0.0, steady.friction * preshear), 0,
                                friction_sd * preshear};
  const StrengthFigures figures = EvaluateStrength(locus, reference);

  auto& responses = measurement->responses;
  const auto add = [&](const char* name, const Estimate& estimate, double scale) {
    responses[name] = {scale * estimate.value, scale * scale * Variance(estimate.sd)};
  };
  add("cohesion", figures.cohesion, unit);
  add("tan_phi", figures.tan_phi, 1);
  add("phi", figures.phi, 1);
  add("unconfined_yield_strength", figures.unconfined_yield_strength, unit);
  add("major_principal_stress", figures.major_principal_stress, unit);
  add("inverse_ffc", figures.inverse_flow_function, 1);
  add("effective_friction_angle", figures.effective_friction_angle, 1);
  add("steady_state_angle", figures.steady_state_angle, 1);
  add("steady_state_friction", {steady.friction, friction_sd}, 1);
  add("preshear_shear_stress", {reference.shear, reference.shear_sd}, unit);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double shear = points[i].shear + locus.tan_phi * (normals[i] - points[i].normal);
    add(ShearStressName(i).c_str(), {shear, points[i].shear_sd}, unit);
    measurement->diagnostics[fmt::format("yield_normal_stress_{}", i + 1)] = points[i].normal;
  }
  auto& notes = measurement->diagnostics;
  if (std::isfinite(figures.flow_function_coefficient.value)) {
    notes["ffc"] = figures.flow_function_coefficient.value;
  }
  double squares = 0;
  double mean = 0;
  for (const ShearPoint& point : points) {
    const double residual = point.shear - locus.ShearAt(point.normal);
    squares += residual * residual / static_cast<double>(points.size());
    mean += point.shear / static_cast<double>(points.size());
  }
  notes["locus_residual"] = std::sqrt(squares) / mean;
  for (const ShearWarning& warning : EvaluateStrength(points, reference).warnings) {
    notes[fmt::format("warning_{}", NameOf(warning.kind))] = 1;
  }
}

// Points of one normal stress, within kMatch, as one.
std::vector<ShearPoint> MergeRepeated(std::vector<ShearPoint> points) {
  std::sort(points.begin(), points.end(),
            [](const ShearPoint& a, const ShearPoint& b) { return a.normal < b.normal; });
  std::vector<ShearPoint> merged;
  for (std::size_t i = 0; i < points.size();) {
    std::size_t end = i;
    while (end < points.size() && points[end].normal <= points[i].normal * (1 + kMatch)) ++end;
    merged.push_back(MeanPoint(std::span(points).subspan(i, end - i)));
    i = end;
  }
  return merged;
}

}  // namespace

Shear::Shear() { SetNormalStresses({0, 0, 0}); }

const std::string& Shear::name() const {
  static const std::string kName = "shear";
  return kName;
}

void Shear::SetNormalStresses(std::vector<double> stresses) {
  normal_stresses_ = std::move(stresses);
  responses_ = {
      {"cohesion", "Pa", "c of the yield locus tau = c + sigma tan(phi)"},
      {"effective_friction_angle", "rad", "effective angle of internal friction in steady state"},
      {"inverse_ffc", "1", "unconfined yield strength over major principal stress, 1/ffc"},
      {"major_principal_stress", "Pa", "sigma_1 of the steady state's Mohr circle"},
      {"phi", "rad", "angle of internal friction, the slope of the yield locus"},
      {"preshear_shear_stress", "Pa", "shear stress of steady state at the preshear normal stress"},
      {"steady_state_angle", "rad", "atan of shear over normal stress in steady state"},
      {"steady_state_bulk_density", "kg/m3", "mass over volume in steady state"},
      {"steady_state_friction", "1", "shear over normal stress in steady state"},
      {"steady_state_void_ratio", "1", "void over solid volume in steady state"},
      {"tan_phi", "1", "slope of the yield locus"},
      {"unconfined_yield_strength", "Pa", "sigma_c of the yield locus"},
  };
  for (std::size_t i = 0; i < normal_stresses_.size(); ++i) {
    const std::string stress = normal_stresses_[i] > 0 ? HumanQuantity(normal_stresses_[i], "Pa")
                                                       : fmt::format("normal stress {}", i + 1);
    responses_.push_back(
        {ShearStressName(i), "Pa", fmt::format("shear stress at yield under {}", stress)});
  }
  std::sort(responses_.begin(), responses_.end(),
            [](const auto& a, const auto& b) { return a.name < b.name; });
}

void Shear::Serialize(Archive& archive) {
  archive.Require("preshear");
  archive.Quantity("preshear", preshear_, "Pa", kPositive);
  normal_stresses_given_ = archive.Has("normal_stresses");
  std::vector<double> stresses = normal_stresses_;
  archive.Quantities("normal_stresses", stresses, "Pa", kPositive);
  archive.Enumeration("cell", cell_, "shear cell", ShearCellNames());
  archive.Quantity("inertial_number", inertial_number_, "1",
                   {.lower = 0, .upper = 0.1, .lower_open = true});
  archive.Quantity("preshear_strain", preshear_strain_, "1", {.lower = 0.5, .upper = 1000});
  archive.Quantity("yield_strain", yield_strain_, "1", {.lower = 2 * kYieldWindow, .upper = 10});
  archive.Integer("repeats", repeats_, {.lower = 1, .upper = 100});
  if (!archive.reading()) return;
  if (!normal_stresses_given_) {
    stresses = {preshear_ * 3 / 9, preshear_ * 5 / 9, preshear_ * 7 / 9};
  }
  std::vector<double> distinct = stresses;
  std::sort(distinct.begin(), distinct.end());
  if (stresses.size() < 2 ||
      std::adjacent_find(distinct.begin(), distinct.end()) != distinct.end()) {
    throw archive.ErrorAt("normal_stresses", "a yield locus needs two or more, all different");
  }
  if (distinct.back() > preshear_) {
    throw archive.ErrorAt("normal_stresses", fmt::format("{} is more than the preshear of {}",
                                                         HumanQuantity(distinct.back(), "Pa"),
                                                         HumanQuantity(preshear_, "Pa")));
  }
  SetNormalStresses(std::move(stresses));
}

std::span<const std::string> Shear::observed_files() const {
  static const std::array<std::string, 1> kFiles = {"yield_locus"};
  return kFiles;
}

std::vector<ObservedValue> Shear::ReadObserved(const std::string& key, const std::string& path) {
  const ShearTest test = ReadYieldLocus(path);
  const auto error = [&](const std::string& problem, const char* column, double value) {
    return InputError(problem,
                      {.location = {path}, .key = column, .value = HumanQuantity(value, "Pa")});
  };
  for (const std::vector<ShearPoint>* rows : {&test.points, &test.preshears}) {
    for (const ShearPoint& point : *rows) {
      if (point.shear_sd > 0) continue;
      throw error(fmt::format("'{}' needs a standard deviation for every shear stress; missing "
                              "where the normal stress is",
                              key),
                  "shear_stress_sd", point.normal);
    }
  }
  const std::vector<ShearPoint> points = MergeRepeated(test.points);
  if (!normal_stresses_given_) {
    std::vector<double> normals;
    for (const ShearPoint& point : points) normals.push_back(point.normal);
    if (!(normals.front() > 0) || normals.back() > preshear_ * (1 + kMatch)) {
      throw error(fmt::format("normal stresses must be positive and at most the preshear, {}",
                              HumanQuantity(preshear_, "Pa")),
                  "normal_stress", normals.front() > 0 ? normals.back() : normals.front());
    }
    SetNormalStresses(std::move(normals));
  }
  std::vector<ObservedValue> observed;
  for (const ShearPoint& point : points) {
    const auto same =
        std::find_if(normal_stresses_.begin(), normal_stresses_.end(),
                     [&](double stress) { return std::abs(point.normal / stress - 1) <= kMatch; });
    if (same == normal_stresses_.end()) {
      throw error("the study's normal_stresses have none within 1 % of the file's", "normal_stress",
                  point.normal);
    }
    const auto index = static_cast<std::size_t>(same - normal_stresses_.begin());
    observed.push_back({ShearStressName(index), point.shear, point.shear_sd});
  }
  if (test.preshears.empty()) return observed;
  const ShearPoint preshear = MeanPoint(test.preshears);
  if (std::abs(preshear.normal / preshear_ - 1) > kMatch) {
    throw error(fmt::format("the file's preshears are not within 1 % of the study's, {}",
                            HumanQuantity(preshear_, "Pa")),
                "normal_stress", preshear.normal);
  }
  observed.push_back({"preshear_shear_stress", preshear.shear, preshear.shear_sd});
  return observed;
}

double Shear::InertialNumber(Fidelity fidelity) const {
  return inertial_number_.value_or(SizeOf(fidelity).inertial_number);
}

void Shear::DescribeConditions(Fidelity /*fidelity*/, Conditions& conditions) const {
  conditions.stress = preshear_;
  conditions.gravity.reset();
}

void Shear::DescribeSimulation(const SimulatedPowder& powder, Fidelity fidelity,
                               Conditions& simulation) const {
  const double d = powder.sizes.Moment(1);
  simulation.gravity.reset();
  simulation.width = SizeOf(fidelity).width * d;
  simulation.shear_rate = InertialNumber(fidelity) /
                          (d * std::sqrt(powder.materials.density / simulation.stress.value()));
}

std::string Shear::ExplainUnsupported(const SimulatedPowder& powder) const {
  if (powder.law.tangential == ContactLaw::Tangential::history) return "";
  return "tangential: no_history has no static friction, so that powder creeps under any shear "
         "stress and there is no yield point; a shear test needs tangential: history";
}

double Shear::Chi(const Program& program) const {
  const double inertial_time = program.particles.sizes.Moment(1) *
                               std::sqrt(program.materials.density / PreshearStress(program));
  return program.materials.particle_particle.rolling_friction *
         (program.time_step / inertial_time) / InertialNumber(program.fidelity);
}

std::vector<std::string> Shear::Warnings(const Program& program) const {
  if (program.law.rolling != ContactLaw::Rolling::cdt) return {};
  const double chi = Chi(program);
  if (chi <= kChiLimit) return {};
  return {fmt::format(
      "shear: with rolling: cdt and rolling_friction {:.3g}, chi = mu_r (dt/t_i)/I is {:.2g}; "
      "above {:g} the rolling torque dithers from step to step, and strength and density depend on "
      "time step and rate instead of rolling_friction (rolling: epsd2 does not dither)",
      program.materials.particle_particle.rolling_friction, chi, kChiLimit)};
}

Program Shear::Plan(const SimulatedPowder& powder, const Conditions& conditions,
                    const Numerics& numerics, Fidelity fidelity, std::uint64_t seed) const {
  const CellSize size = SizeOf(fidelity);
  const double scale = conditions.stress.value() / preshear_;
  ShearProtocol protocol{.cell = cell_,
                         .count = size.count,
                         .width = size.width * powder.sizes.Moment(1),
                         .preshear = conditions.stress.value(),
                         .inertial_number = InertialNumber(fidelity),
                         .preshear_strain = preshear_strain_.value_or(size.preshear_strain),
                         .yield_strain = yield_strain_,
                         .repeats = repeats_};
  for (const double stress : normal_stresses_) protocol.normals.push_back(scale * stress);
  Program program = PlanShear(protocol, powder, seed);
  program.experiment = name();
  program.fidelity = fidelity;
  program.time_step = numerics.TimeStep(powder);
  return program;
}

// Loading between platens, not counted, takes a small part of it.
double Shear::ExpectedDuration(const Program& program) const {
  double duration = 0;
  for (const Stage& stage : program.stages) {
    if (const Deform* deform = std::get_if<Deform>(&stage)) duration += deform->duration;
    if (const Advance* advance = std::get_if<Advance>(&stage)) duration += advance->duration;
  }
  return duration;
}

Measurement Shear::Measure(const Program& program, const Trace& trace, Outcome* outcome) const {
  Measurement measurement;
  if (!trace.reported.empty()) {  // a backend that knows responses without a simulation
    for (const auto& [response, reported] : trace.reported) {
      measurement.responses[response] = {reported.value, reported.variance};
    }
    return measurement;
  }
  ShearRecord record;
  if (const std::string problem = ReadShearRecord(program, trace, &record); !problem.empty()) {
    *outcome = {Reason::crashed, problem};
    return measurement;
  }
  const auto fail = [&](std::string problem) {
    *outcome = {Reason::not_quasi_static, std::move(problem)};
    return measurement;
  };
  auto& notes = measurement.diagnostics;
  const double preshear = PreshearStress(program);
  notes["inertial_number"] = InertialNumber(program.fidelity);
  notes["kappa"] =
      StiffnessNumber(program.materials.young_modulus, program.materials.poisson_ratio, preshear);
  if (program.law.rolling == ContactLaw::Rolling::cdt) notes["chi"] = Chi(program);
  notes["simulated_time"] = trace.moments.back().time;
  if (record.preshear.size() < kFewestSamples) {
    return fail(
        fmt::format("only {} windows of averaging in the preshear: the time step is too "
                    "long for this rate",
                    record.preshear.size()));
  }

  const std::vector<double> shears = Values(record.preshear, ShearOf);
  const std::vector<double> voids = Values(record.preshear, VoidRatioOf);
  const std::size_t start = std::max(FindTruncation(shears), FindTruncation(voids));
  const Steady steady = MeasureSteady(std::span<const ShearSample>(record.preshear).subspan(start));
  const double strain = record.preshear.back().strain;
  const double samples_per_strain = static_cast<double>(record.preshear.size()) / strain;
  const DriftOptions options{.memory = kMemoryStrain * samples_per_strain};
  const Drift shear_drift = MeasureDrift(std::span<const double>(shears).subspan(start), options);
  const Drift void_drift = MeasureDrift(std::span<const double>(voids).subspan(start), options);
  notes["steady_state_strain"] = record.preshear[start].strain;
  notes["shear_drift"] = shear_drift.value;
  notes["void_ratio_drift"] = void_drift.value;
  notes["memory_strain"] =
      MeanOf(Values(steady.samples, ShearOf)).inefficiency / samples_per_strain;
  for (const auto& [what, drift] :
       {std::pair{"shear stress", shear_drift}, {"void ratio", void_drift}}) {
    if (drift.steady) continue;
    return fail(fmt::format(
        "no steady state within a strain of {:.3g}: from {:.3g} on the {} still drifts, by {:.1f} "
        "% "
        "± {:.1f} % over half of the rest",
        strain, record.preshear[start].strain, what, 100 * drift.value, 100 * drift.error));
  }
  if (std::string problem = ExplainDisagreement(program, steady, &notes); !problem.empty()) {
    return fail(std::move(problem));
  }

  const double scale = preshear / preshear_;
  std::vector<double> normals;
  for (const double stress : normal_stresses_) normals.push_back(scale * stress);
  YieldTable yields;
  if (std::string problem = ReadYields(record, normals, steady.friction, &yields);
      !problem.empty()) {
    return fail(std::move(problem));
  }
  notes["plain_scatter"] = RelativeScatter(yields);
  Prorate(record, steady.friction, &yields);
  notes["prorated_scatter"] = RelativeScatter(yields);
  AddResponses(normals, yields, steady, preshear, 1 / scale, &measurement);
  const double e = steady.mean.void_ratio;
  const double density = program.materials.density / (1 + e);
  measurement.responses["steady_state_void_ratio"] = {e, steady.void_ratio_variance};
  measurement.responses["steady_state_bulk_density"] = {
      density, steady.void_ratio_variance * density * density / ((1 + e) * (1 + e))};
  return measurement;
}

}  // namespace powdercal
