# powdercal_library(FOLDER SOURCES a.cc … DEPENDS core … LIBRARIES Eigen3::Eigen …)
# One static library per folder: powdercal_FOLDER, also known as powdercal::FOLDER. No name that is private
# to one of its sources occurs in another.
function(powdercal_library folder)
  cmake_parse_arguments(arg "" "" "SOURCES;DEPENDS;LIBRARIES;PRIVATE_LIBRARIES" ${ARGN})
  set(target powdercal_${folder})
  add_library(${target} STATIC ${arg_SOURCES})
  add_library(powdercal::${folder} ALIAS ${target})
  set_target_properties(${target} PROPERTIES EXPORT_NAME ${folder})
  target_include_directories(${target} PUBLIC
    $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}>
    $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}/powdercal>)
  foreach(dependency IN LISTS arg_DEPENDS)
    target_link_libraries(${target} PUBLIC powdercal_${dependency})
  endforeach()
  target_link_libraries(${target} PUBLIC ${arg_LIBRARIES} PRIVATE ${arg_PRIVATE_LIBRARIES})
  powdercal_compile_options(${target})
  powdercal_compile_together(${target})
  set_property(GLOBAL APPEND PROPERTY POWDERCAL_LIBRARIES ${target})
endfunction()

# Several sources at a time, where the preset says so.
function(powdercal_compile_together target)
  if(NOT POWDERCAL_COMPILE_TOGETHER)
    return()
  endif()
  set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE 6)
  if(CMAKE_CXX_COMPILER_ID STREQUAL GNU)
    # It takes a source that is included by another file for a header.
    target_compile_options(${target} PRIVATE -Wno-subobject-linkage)
  endif()
endfunction()

function(powdercal_compile_options target)
  # No contraction into fused multiply-add: the same study gives the same numbers on every machine.
  target_compile_options(${target} PRIVATE
    -Wall -Wextra -Wpedantic -Wshadow -Wnon-virtual-dtor -Woverloaded-virtual
    -Wno-missing-field-initializers -ffp-contract=off)
  if(CMAKE_CXX_COMPILER_ID STREQUAL GNU)
    # GCC 12 reports both falsely for std::string at -O2 and above (its bugs 105329 and 105651).
    target_compile_options(${target} PRIVATE -Wno-restrict -Wno-maybe-uninitialized)
  endif()
  target_compile_features(${target} PUBLIC cxx_std_20)
  if(POWDERCAL_WARNINGS_AS_ERRORS)
    target_compile_options(${target} PRIVATE -Werror)
  endif()
  if(POWDERCAL_SANITIZE)
    target_compile_options(${target} PUBLIC
      $<BUILD_INTERFACE:-fsanitize=${POWDERCAL_SANITIZE};-fno-omit-frame-pointer;-fno-sanitize-recover=all>)
    target_link_options(${target} PUBLIC $<BUILD_INTERFACE:-fsanitize=${POWDERCAL_SANITIZE}>)
  endif()
endfunction()
