#include "verification/finding.h"

namespace powdercal::verification {

std::span<const std::string> RungNames() {
  static const std::vector<std::string> kNames = {"contact", "packing", "experiment",
                                                  "calibration"};
  return kNames;
}

const std::string& ToString(Rung rung) { return RungNames()[static_cast<std::size_t>(rung)]; }

std::span<const std::string> VerdictNames() {
  static const std::vector<std::string> kNames = {"equivalent", "different", "undecided", "failed",
                                                  "unsupported"};
  return kNames;
}

const std::string& ToString(Verdict verdict) {
  return VerdictNames()[static_cast<std::size_t>(verdict)];
}

bool SpeaksAgainst(Verdict verdict) {
  return verdict != Verdict::equivalent && verdict != Verdict::unsupported;
}

Verdict Overall(std::span<const Quantity> quantities) {
  Verdict overall = Verdict::equivalent;
  for (const Quantity& quantity : quantities) {
    if (!quantity.counts || !SpeaksAgainst(quantity.verdict)) continue;
    if (quantity.verdict == Verdict::different) return Verdict::different;
    overall = Verdict::undecided;
  }
  return overall;
}

}  // namespace powdercal::verification
