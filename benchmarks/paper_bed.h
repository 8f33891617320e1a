#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "backends/program.h"
#include "backends/trace.h"

namespace powdercal::benchmarks {

// The seed paper's consolidation simulation, as far as the paper says what it is, with everything
// that it leaves open or that may explain its void ratios as a member.

/// One row of the paper's Table 3.
struct TableRow {
  std::string name;
  double cohesion = 0;    ///< [J/m3] k
  double rolling = 0;     ///< [-] mu_r
  double void_ratio = 0;  ///< [-]
};
/// All 18 rows of studies/library/hastelloy_x_table3.csv, in the paper's order.
const std::vector<TableRow>& Table3();

/// How a bed is made and loaded. The defaults are the paper's own figures (Table 1), and where it
/// has none those of LIGGGHTS.
struct BedSetup {
  // Contact law
  ContactLaw law{.limit_force = false,
                 .tangential = ContactLaw::Tangential::no_history,
                 .cohesion = ContactLaw::Cohesion::sjkr2,
                 .rolling = ContactLaw::Rolling::cdt,
                 .torsion = false};
  double time_step = 1e-6;     ///< [s]
  double friction = 0.3;       ///< [-]
  double restitution = 0.4;    ///< [-]
  double young_modulus = 5e6;  ///< [Pa]
  bool sticky_walls = true;    ///< floor and lid attract with k and roll with mu_r
  double cohesion_factor = 1;  ///< [-] on k
  bool no_rolling = false;     ///< mu_r = 0 whatever the row says

  // Powder: number mean 29 um
  enum class Sizes { equal, narrow, wide };
  Sizes sizes = Sizes::wide;  ///< narrow, wide: sd 2, 6 um; wide is cut at 12.5 and 37.5 um
  double diameter = 29e-6;    ///< [m] number mean

  // Bed
  int particles = 1000;
  double width = 10;            ///< [d]
  double solid_fraction = 0.3;  ///< [-] as inserted
  double velocity = 0;          ///< [m/s] downwards, of all particles at the beginning
  double drop = 0;              ///< [m] of the lowest particle at the beginning
  double gravity = 9.81;        ///< [m/s2]
  double settle_time = 0;       ///< [s] 0: until at rest, as the consolidation experiment settles

  // Load
  double stress = 900;                 ///< [Pa] 0: none, the bed bears its own weight
  double lid_speed = 0.1;              ///< [m/s] at most
  double hold = 16e-3;                 ///< [s] under load; without load, after settling
  static constexpr int kReadings = 8;  ///< on the way of the hold

  double Width() const { return width * diameter; }  ///< [m]
};

/// The program of a bed at a row of the table. Stages: insert, settle, servo (with a load), hold.
Program MakeBed(const BedSetup& setup, double cohesion, double rolling, std::uint64_t seed);

/// The void ratio at one moment, in several estimates.
struct Reading {
  std::string moment;        ///< "settle", "servo" or "hold"
  double time = 0;           ///< [s] since the end of settling
  double height = 0;         ///< [m] of the lid, or of the bed's top without one
  double stress = 0;         ///< [Pa] on the lid, mean since the last reading; 0 without one
  double central = 0;        ///< [-] between 20 and 80 % of the height
  double wall_to_wall = 0;   ///< [-] over the whole height
  double less_overlaps = 0;  ///< [-] central, overlap volume counted once
  double mean_diameter = 0;  ///< [-] wall to wall, each particle as large as the mean diameter says
  double coordination = 0;   ///< [-] mean number of contacts
  double kinetic = 0;        ///< [-] kinetic energy over N m g d, m and g those of the bed
};
/// Of a packing under a lid at `lid_height` [m]; without one (or one that is above everything)
/// between the floor and the height below which 99 % of the centres lie, plus half a mean diameter.
Reading Read(const Program& program, const Packing& packing, std::optional<double> lid_height,
             double stress);
/// Of all moments of a run.
std::vector<Reading> ReadAll(const Program& program, const Trace& trace);

nlohmann::json ToJson(const Reading& reading);
Reading ReadingFromJson(const nlohmann::json& json);

}  // namespace powdercal::benchmarks
