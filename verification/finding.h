#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

namespace powdercal::verification {

/// The steps of the ladder, from two spheres to a whole calibration.
enum class Rung { contact, packing, experiment, calibration };
std::span<const std::string> RungNames();
const std::string& ToString(Rung rung);

/// What was found of two backends.
enum class Verdict {
  equivalent,   ///< every difference that counts is shown to be within its tolerance
  different,    ///< one is shown to be beyond it
  undecided,    ///< neither is shown: more seeds would tell
  failed,       ///< a simulation that both should be able to do did not come to its end
  unsupported,  ///< one of them cannot do it, or is not there
};
std::span<const std::string> VerdictNames();
const std::string& ToString(Verdict verdict);

/// Whether a verdict speaks against the backends: all but `equivalent` and `unsupported`.
bool SpeaksAgainst(Verdict verdict);

/// What particle seeds gave for one quantity in two backends, a and b.
struct SeedStatistics {
  int n = 0;  ///< pairs of runs with the same seed
  double mean_a = 0;
  double mean_b = 0;
  double sd_a = 0;  ///< of single runs
  double sd_b = 0;
  double sd_difference = 0;  ///< of b − a, seed by seed
  double lower = 0;          ///< of the confidence interval of the mean difference
  double upper = 0;
  double p = 1;          ///< of the two one-sided tests: the larger of both
  int seeds_needed = 0;  ///< that would probably decide; 0: decided, or no number would
};

/// One quantity in which two backends are compared.
struct Quantity {
  std::string name;       ///< "position"; "void_ratio at 900 Pa"
  std::string unit;       ///< SI, "1" for pure numbers
  std::string scale;      ///< what the difference is relative to, "" if to nothing
  double difference = 0;  ///< contact: the largest at any time; else mean of b − a
  double tolerance = 0;   ///< contact: bound of the difference; else margin of equivalence
  std::string tolerance_reason;
  std::optional<SeedStatistics> seeds;
  Verdict verdict = Verdict::unsupported;
  bool counts = true;  ///< false: shown, without weight in the verdict
  std::string note;
};

/// The verdict on a pair of backends in one case of a rung.
struct Finding {
  Rung rung = Rung::contact;
  std::string name;   ///< of the case: "oblique", "bed", "consolidation"
  std::string level;  ///< of a contact: which law the case looks at (docs/validation); "" elsewhere
  std::string a;      ///< the backend that is the reference
  std::string b;
  Verdict verdict = Verdict::unsupported;
  std::string reason;  ///< of all verdicts but `equivalent`; for people
  std::string note;    ///< what else there is to say
  std::string law_a;   ///< as it was asked for; "" where nothing was run
  std::string law_b;
  std::vector<Quantity> quantities;
};

/// The verdict on all quantities that count: the worst of theirs, in the order different,
/// undecided, equivalent.
Verdict Overall(std::span<const Quantity> quantities);

}  // namespace powdercal::verification
