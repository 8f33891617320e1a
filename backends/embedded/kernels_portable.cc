#define POWDERCAL_ISA portable
#include "backends/embedded/contact_kernels.inc"

namespace powdercal::embedded {

extern const KernelTable kPortableKernels;
const KernelTable kPortableKernels = portable::MakeTable();

}  // namespace powdercal::embedded
