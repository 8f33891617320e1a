#include "verification/forms.h"

#include <fmt/format.h>

#include <algorithm>

namespace powdercal::verification {
namespace {

using Normal = ContactLaw::Normal;
using Rolling = ContactLaw::Rolling;
using ShearUpdate = ContactLaw::ShearUpdate;
using Tangential = ContactLaw::Tangential;

std::string ModelOf(const ContactLaw& law, bool slips, bool twists) {
  std::string model;
  if (slips && law.normal == Normal::hertz && law.tangential == Tangential::history) {
    model += ShearUpdateNames()[static_cast<std::size_t>(law.shear_update)];
  }
  if (twists && law.rolling != Rolling::none) model += law.torsion ? "+torsion" : "-torsion";
  return model;
}

}  // namespace

std::vector<Form> FormsOf(const Program& program, bool slips, bool twists) {
  std::vector<Form> forms;
  const ContactLaw& own = program.law;
  const auto add = [&](bool other_update, bool other_torsion) {
    Form form{.program = program};
    ContactLaw& law = form.program.law;
    if (other_update) {
      law.shear_update = own.shear_update == ShearUpdate::displacement ? ShearUpdate::incremental
                                                                       : ShearUpdate::displacement;
    }
    if (other_torsion) law.torsion = !own.torsion;
    form.model = ModelOf(law, slips, twists);
    forms.push_back(std::move(form));
  };
  const bool history = own.tangential == Tangential::history;
  add(false, false);
  if (history) add(true, false);
  if (own.rolling != Rolling::none) {
    add(false, true);
    if (history) add(true, true);
  }
  return forms;
}

std::vector<std::string> ExplainForms(const Contender& contender, const std::vector<Form>& forms) {
  std::vector<std::string> reasons;
  for (const Form& form : forms) reasons.push_back(contender.ExplainUnsupported(form.program));
  return reasons;
}

std::optional<FormChoice> ChooseForms(const std::vector<Form>& forms,
                                      const std::vector<std::string>& a,
                                      const std::vector<std::string>& b) {
  std::optional<FormChoice> best;
  for (std::size_t i = 0; i < forms.size(); ++i) {
    for (std::size_t j = 0; j < forms.size(); ++j) {
      if (!a[i].empty() || !b[j].empty() || forms[i].model != forms[j].model) continue;
      if (!best || i + j < best->a + best->b) best = FormChoice{i, j};
    }
  }
  return best;
}

std::string ExplainNoForm(const std::string& name_a, const std::vector<std::string>& a,
                          const std::string& name_b, const std::vector<std::string>& b) {
  const auto none = [](const std::vector<std::string>& reasons) {
    return std::none_of(reasons.begin(), reasons.end(),
                        [](const std::string& reason) { return reason.empty(); });
  };
  // Of several reasons the last form's: what stands in the way of the first may be a matter of
  // form.
  const auto essential = [](const std::vector<std::string>& reasons) { return reasons.back(); };
  if (none(a)) return fmt::format("{}: {}", name_a, essential(a));
  if (none(b)) return fmt::format("{}: {}", name_b, essential(b));
  std::string text = "no form of the law that both have";
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (a[i].empty() || !b[i].empty()) continue;
    text += fmt::format("; {}: {}", name_a, a[i]);
    break;
  }
  for (std::size_t i = 0; i < b.size(); ++i) {
    if (b[i].empty() || !a[i].empty()) continue;
    text += fmt::format("; {}: {}", name_b, b[i]);
    break;
  }
  return text;
}

void NoteForms(const std::vector<Form>& forms, const FormChoice& choice, Finding& finding) {
  finding.law_a = forms[choice.a].program.law.ToString();
  finding.law_b = forms[choice.b].program.law.ToString();
  if (choice.a == 0 && choice.b == 0) return;
  finding.note = finding.law_a == finding.law_b
                     ? fmt::format("in a form that both have: {}", finding.law_a)
                     : fmt::format("in forms that are one here: {} in {}, {} in {}", finding.law_a,
                                   finding.a, finding.law_b, finding.b);
}

}  // namespace powdercal::verification
