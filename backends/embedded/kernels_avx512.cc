#define POWDERCAL_ISA avx512
#include "backends/embedded/contact_kernels.inc"

namespace powdercal::embedded {

extern const KernelTable kAvx512Kernels;
const KernelTable kAvx512Kernels = avx512::MakeTable();

}  // namespace powdercal::embedded
