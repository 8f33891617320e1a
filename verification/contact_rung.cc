#include "verification/contact_rung.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "verification/forms.h"

namespace powdercal::verification {
namespace {

double Length(const Vector3& v) { return std::hypot(v[0], v[1], v[2]); }
Vector3 Minus(const Vector3& a, const Vector3& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}

// The larger one, and for good what is not a number.
void Widen(double& largest, double value) {
  if (!std::isnan(largest) && !(value <= largest)) largest = value;
}

Packing ById(Packing packing) {
  std::sort(packing.begin(), packing.end(),
            [](const Sphere& a, const Sphere& b) { return a.id < b.id; });
  return packing;
}

// One case in all its forms, and what each backend made of them.
struct CaseRuns {
  ContactCase contact;
  std::vector<Form> forms;
  std::vector<std::vector<std::string>> why_not;  // by contender and form
};

class ContactVerifier {
 public:
  ContactVerifier(std::span<const Contender> contenders, const RunOptions& options)
      : contenders_(contenders), options_(options) {}

  std::vector<Finding> Verify(const Subject& subject) {
    for (ContactCase& contact : ContactCases(subject)) {
      CaseRuns runs{.forms = FormsOf(contact.program, contact.slips, contact.twists)};
      runs.contact = std::move(contact);
      for (const Contender& contender : contenders_) {
        runs.why_not.push_back(ExplainForms(contender, runs.forms));
      }
      cases_.push_back(std::move(runs));
    }
    Plan();
    Run();
    std::vector<Finding> findings;
    for (const CaseRuns& runs : cases_) {
      for (std::size_t a = 0; a < contenders_.size(); ++a) {
        for (std::size_t b = a + 1; b < contenders_.size(); ++b) {
          findings.push_back(Judge(runs, a, b));
        }
      }
    }
    return findings;
  }

 private:
  struct Key {
    const CaseRuns* runs = nullptr;
    std::size_t contender = 0;
    std::size_t form = 0;
    auto operator<=>(const Key&) const = default;
  };
  struct Result {
    Outcome outcome;
    Trace trace;
  };

  void Plan() {
    for (const CaseRuns& runs : cases_) {
      for (std::size_t a = 0; a < contenders_.size(); ++a) {
        for (std::size_t b = a + 1; b < contenders_.size(); ++b) {
          const auto choice = ChooseForms(runs.forms, runs.why_not[a], runs.why_not[b]);
          if (!choice) continue;
          results_[{&runs, a, choice->a}];
          results_[{&runs, b, choice->b}];
        }
      }
    }
  }

  void Run() {
    std::vector<Job> jobs;
    for (auto& [key, result] : results_) {
      Trace* trace = &result.trace;
      jobs.push_back({.contender = &contenders_[key.contender],
                      .program = key.runs->forms[key.form].program,
                      .name = key.runs->contact.name,
                      .keep = false,
                      .measure = [trace](const Trace& measured, Outcome*) {
                        *trace = measured;
                        return Measurement();
                      }});
    }
    const std::vector<LedgerRun> runs = RunJobs(Rung::contact, jobs, options_);
    std::size_t n = 0;
    for (auto& [key, result] : results_) result.outcome = runs[n++].outcome;
  }

  Finding Judge(const CaseRuns& runs, std::size_t a, std::size_t b) const {
    Finding finding{.rung = Rung::contact,
                    .name = runs.contact.name,
                    .level = runs.contact.level,
                    .a = contenders_[a].name,
                    .b = contenders_[b].name};
    const auto choice = ChooseForms(runs.forms, runs.why_not[a], runs.why_not[b]);
    if (!choice) {
      finding.reason = ExplainNoForm(finding.a, runs.why_not[a], finding.b, runs.why_not[b]);
      return finding;
    }
    NoteForms(runs.forms, *choice, finding);
    const Result& first = results_.at({&runs, a, choice->a});
    const Result& second = results_.at({&runs, b, choice->b});
    for (const auto& [contender, result] : {std::pair{a, &first}, std::pair{b, &second}}) {
      if (result->outcome.ok()) continue;
      finding.verdict = Verdict::failed;
      finding.reason = fmt::format("{}: {}, {}", contenders_[contender].name,
                                   ToString(result->outcome.reason), result->outcome.message);
      return finding;
    }
    Outcome outcome;
    const double tolerance = ContactTolerance(runs.contact, runs.forms[choice->a].program.law);
    finding.quantities = CompareTrajectories(first.trace, second.trace, tolerance, &outcome);
    if (!outcome.ok()) {
      finding.verdict = Verdict::failed;
      finding.reason = outcome.message;
      return finding;
    }
    finding.verdict = Overall(finding.quantities);
    for (const Quantity& quantity : finding.quantities) {
      if (quantity.verdict != Verdict::different) continue;
      finding.reason +=
          fmt::format("{}{} off by {:.2g}, tolerance {:.0e}", finding.reason.empty() ? "" : "; ",
                      quantity.name, quantity.difference, quantity.tolerance);
    }
    return finding;
  }

  std::span<const Contender> contenders_;
  const RunOptions& options_;
  std::vector<CaseRuns> cases_;
  std::map<Key, Result> results_;
};

}  // namespace

std::vector<Quantity> CompareTrajectories(const Trace& a, const Trace& b, double tolerance,
                                          Outcome* outcome) {
  const auto fail = [&](const std::string& message) {
    *outcome = {Reason::crashed, message};
    return std::vector<Quantity>();
  };
  if (a.moments.empty() || a.moments.size() != b.moments.size()) {
    return fail(fmt::format("{} packings on the way in one, {} in the other", a.moments.size(),
                            b.moments.size()));
  }
  double position = 0;
  double velocity = 0;
  double spin = 0;
  double fastest = 0;
  for (std::size_t frame = 0; frame < a.moments.size(); ++frame) {
    const Moment& m = a.moments[frame];
    const Moment& n = b.moments[frame];
    const double step = m.time / static_cast<double>(frame + 1);
    if (std::abs(m.time - n.time) > 1e-4 * step) {
      return fail(fmt::format("packing {} is of {:.6g} s in one and of {:.6g} s in the other",
                              frame, m.time, n.time));
    }
    const Packing p = ById(m.packing);
    const Packing q = ById(n.packing);
    if (p.size() != q.size()) return fail("not as many spheres in one as in the other");
    for (std::size_t i = 0; i < p.size(); ++i) {
      const double r = p[i].radius;
      fastest = std::max({fastest, Length(p[i].velocity), r * Length(p[i].spin)});
      Widen(position, Length(Minus(p[i].position, q[i].position)) / r);
      Widen(velocity, Length(Minus(p[i].velocity, q[i].velocity)));
      Widen(spin, r * Length(Minus(p[i].spin, q[i].spin)));
    }
  }
  if (fastest <= 0) return fail("nothing moves");
  const auto quantity = [&](const char* name, const char* scale, double difference) {
    return Quantity{.name = name,
                    .unit = "1",
                    .scale = scale,
                    .difference = difference,
                    .tolerance = tolerance,
                    .verdict = difference <= tolerance ? Verdict::equivalent : Verdict::different};
  };
  constexpr const char* kSpeed = "largest speed of a centre or a surface";
  return {quantity("position", "radius", position),
          quantity("velocity", kSpeed, velocity / fastest),
          quantity("spin", "the same, of the surface", spin / fastest)};
}

std::vector<Finding> VerifyContacts(const Subject& subject, std::span<const Contender> contenders,
                                    const RunOptions& options) {
  return ContactVerifier(contenders, options).Verify(subject);
}

}  // namespace powdercal::verification
