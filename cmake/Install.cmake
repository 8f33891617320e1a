include(CMakePackageConfigHelpers)

get_property(powdercal_libraries GLOBAL PROPERTY POWDERCAL_LIBRARIES)
install(TARGETS ${powdercal_libraries} EXPORT powdercalTargets
        ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR})
install(TARGETS powdercal_program RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
foreach(folder core scaling surrogates backends experiments optimizers studies verification reports)
  install(DIRECTORY ${folder} DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/powdercal
          FILES_MATCHING PATTERN "*.h" PATTERN assets EXCLUDE PATTERN library EXCLUDE)
endforeach()
install(DIRECTORY studies/library/ DESTINATION ${CMAKE_INSTALL_DATADIR}/powdercal/studies)
install(EXPORT powdercalTargets NAMESPACE powdercal:: FILE powdercalTargets.cmake
        DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/powdercal)
configure_package_config_file(cmake/powdercalConfig.cmake.in powdercalConfig.cmake
  INSTALL_DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/powdercal)
write_basic_package_version_file(powdercalConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/powdercalConfig.cmake
              ${CMAKE_CURRENT_BINARY_DIR}/powdercalConfigVersion.cmake
              ${CMAKE_CURRENT_SOURCE_DIR}/cmake/Finddlib.cmake
              ${CMAKE_CURRENT_SOURCE_DIR}/cmake/Findudunits2.cmake
              ${CMAKE_CURRENT_SOURCE_DIR}/cmake/Findxgboost.cmake
        DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/powdercal)
