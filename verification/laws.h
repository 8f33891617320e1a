#pragma once

#include <span>
#include <string>

#include "backends/program.h"

namespace powdercal::verification {

/// A contact law with everything that a simulation of it needs: what is verified.
struct Subject {
  std::string name;
  std::string description;  ///< one line, for people
  ContactLaw law;
  Materials materials;
  SizeDistribution sizes;
  double time_step = 0;  ///< [s]
  double stress = 0;     ///< [Pa] middle one of the packings'
};

/// Names of the laws that are shipped, sorted.
std::span<const std::string> LawNames();

/// The law of that name, with softened metal powder: 5 MPa, 8220 kg/m3, nu = 0.3, spheres of 12.5
/// to 37.5 um. Throws InputError for an unknown name.
Subject ShippedLaw(const std::string& name);

}  // namespace powdercal::verification
