#pragma once

#include <Eigen/Core>

namespace powdercal {

/// The paper's Table 3 (Hastelloy X): void ratio after consolidation at 18 pairs of cohesion energy
/// density [J/m3] and rolling friction; inputs scaled linearly from [1e2, 1e5] × [0.05, 0.7] to the
/// unit box. Rows 12 and 16 differ in the friction only and agree in the void ratio.
struct Table3 {
  Eigen::MatrixXd points;
  Eigen::VectorXd void_ratios;
};

inline Table3 ReadTable3() {
  Eigen::Matrix<double, 18, 3> rows;
  rows << 1e2, 0.05, 0.575,  //
      1e5, 0.7, 1.459,       //
      1e2, 0.7, 0.566,       //
      1e5, 0.05, 1.120,      //
      5e2, 0.4, 0.568,       //
      5570, 0.13, 0.569,     //
      70500, 0.37, 1.064,    //
      9100, 0.24, 0.565,     //
      36900, 0.63, 0.658,    //
      42800, 0.31, 0.721,    //
      55400, 0.66, 0.889,    //
      17500, 0.68, 0.566,    //
      56400, 0.49, 0.897,    //
      69800, 0.56, 1.080,    //
      55400, 0.56, 0.886,    //
      42800, 0.55, 0.716,    //
      56400, 0.46, 0.897,    //
      47500, 0.5, 0.776;
  Table3 table{Eigen::MatrixXd(18, 2), rows.col(2)};
  table.points.col(0) = (rows.col(0).array() - 1e2) / (1e5 - 1e2);
  table.points.col(1) = (rows.col(1).array() - 0.05) / (0.7 - 0.05);
  return table;
}

}  // namespace powdercal
