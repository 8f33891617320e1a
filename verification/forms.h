#pragma once

#include <optional>
#include <string>
#include <vector>

#include "backends/program.h"
#include "verification/runs.h"

namespace powdercal::verification {

/// A program with its law in one of the forms that codes know: LIGGGHTS has `shear_update:
/// displacement` only, YADE `incremental` only, and no torsion of rolling friction.
struct Form {
  Program program;
  /// Forms of one model move alike; those of several do not, and are compared with themselves only.
  std::string model;
};

/// The program as it is, then with the other `shear_update` and the other `torsion`. Where nothing
/// slips, or the tangential spring is linear, the updates are one model; where nothing twists,
/// torsion is.
std::vector<Form> FormsOf(const Program& program, bool slips = true, bool twists = true);

/// Why a backend cannot run each of the forms; "" where it can.
std::vector<std::string> ExplainForms(const Contender& contender, const std::vector<Form>& forms);

/// The forms in which two backends are compared, by index.
struct FormChoice {
  std::size_t a = 0;
  std::size_t b = 0;
};
/// The first forms of one model that both can run; `a` and `b` are what ExplainForms() said of
/// each.
std::optional<FormChoice> ChooseForms(const std::vector<Form>& forms,
                                      const std::vector<std::string>& a,
                                      const std::vector<std::string>& b);
/// Why there are none.
std::string ExplainNoForm(const std::string& name_a, const std::vector<std::string>& a,
                          const std::string& name_b, const std::vector<std::string>& b);

/// Puts the laws of the chosen forms into a finding, and what there is to say of them.
void NoteForms(const std::vector<Form>& forms, const FormChoice& choice, Finding& finding);

}  // namespace powdercal::verification
